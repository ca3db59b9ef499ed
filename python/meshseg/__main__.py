"""``python -m meshseg``: the command line."""

import signal
import sys

from ._meshseg import main as run


def main() -> int:
    # Python's handler of Ctrl-C gives way to that of the command line.
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    return run([sys.executable, "-m", "meshseg"], sys.argv[1:])


if __name__ == "__main__":
    sys.exit(main())
