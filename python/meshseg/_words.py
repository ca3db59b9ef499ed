"""Sentences of the command line in Python's words: ``--max-iterations 5`` is ``max_iterations=5``."""

import re
from collections.abc import Iterator
from contextlib import contextmanager

#: What stands for an array in the arguments: a name that no file has.
_MARK = "\ue000"
_ARRAY = re.compile(f"{_MARK}([a-z_]+)\\.npy")
_NUMBER = r"[+-]?[0-9][0-9.]*(?:e[+-]?[0-9]+)?%?(?![0-9a-z])"
_WORD = r"(?:vertices|faces|normals|colors|area|none|albedo|threshold|constant|curvature|(?:image|texture|views):\w+)\b"
_OPTION = re.compile(
    rf"--(?P<name>[a-z][a-z-]*[a-z]|[uq])\b(?:[ =](?P<value>{_NUMBER}|{_WORD})| (?P<hint><[^>]*>))?"
)
_NAMES = {"lambda": "lambda_", "no-weld": "weld=False", "solver-option": "solver_options"}


def name_of(keyword: str) -> str:
    """The option of a keyword."""
    return "solver-option" if keyword == "solver_options" else keyword.rstrip("_").replace("_", "-")


def array_name(keyword: str) -> str:
    """What stands for the array of a keyword in the arguments."""
    return f"{_MARK}{keyword}.npy"


def pythonic(sentence: str) -> str:
    """The sentence with keywords in place of options, and arrays in place of files.

    >>> pythonic(f"{array_name('costs')}: has 3 rows; lambda is too large, try --lambda 1.0e-3")
    'costs: has 3 rows; lambda is too large, try lambda_=1.0e-3'
    >>> pythonic("--q <Q.npy> needs --on faces or --edge-aware normals; leave --weld out")
    'q needs on=faces or edge_aware=normals; leave weld out'
    """

    def keyword(option: re.Match[str]) -> str:
        name = _NAMES.get(option["name"], option["name"].replace("-", "_"))
        return name if option["value"] is None else f"{name}={option['value']}"

    return _OPTION.sub(keyword, _ARRAY.sub(r"\1", sentence))


def in_our_words(error: Exception) -> Exception:
    """An exception of the compiled part in these words; names of files stay as they are."""
    text = str(error)
    return type(error)(_ARRAY.sub(r"\1", text) if isinstance(error, OSError) else pythonic(text))


@contextmanager
def said() -> Iterator[None]:
    """Exceptions of the compiled part, in these words."""
    try:
        yield
    except (OSError, ValueError) as error:
        raise in_our_words(error) from None
