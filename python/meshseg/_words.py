"""Sentences of the command line in Python's words: ``--max-iterations 5`` is ``max_iterations=5``."""

import re
from collections.abc import Iterator
from contextlib import contextmanager

_OPTION = re.compile(r"--(?P<name>[a-z][a-z-]*[a-z])(?: (?P<value>[+-]?[0-9][0-9.]*(?:e[+-]?[0-9]+)?)(?![0-9a-z]))?")
_NAMES = {"lambda": "lambda_", "no-weld": "weld=False", "solver-option": "solver_options"}


def name_of(keyword: str) -> str:
    """The option of a keyword."""
    return "solver-option" if keyword == "solver_options" else keyword.rstrip("_").replace("_", "-")


def pythonic(sentence: str) -> str:
    """The sentence with keywords in place of options, and arrays in place of files.

    >>> pythonic("<costs>.npy: has 3 rows; lambda is too large, try --lambda 1.0e-3")
    'costs: has 3 rows; lambda is too large, try lambda_=1.0e-3'
    """

    def keyword(option: re.Match[str]) -> str:
        name = _NAMES.get(option["name"], option["name"].replace("-", "_"))
        return name if option["value"] is None else f"{name}={option['value']}"

    return _OPTION.sub(keyword, re.sub(r"<([a-z_]+)>\.npy", r"\1", sentence))


@contextmanager
def said() -> Iterator[None]:
    """Exceptions of the compiled part, in these words."""
    try:
        yield
    except (OSError, ValueError) as error:
        raise type(error)(pythonic(str(error))) from None
