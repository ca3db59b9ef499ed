"""python -m meshseg_reference SOLVER PROBLEM.npz OUT [--max-iterations=N] [--time-limit=SECONDS]
                               [--threads=N] [--key=value ...]
python -m meshseg_reference check PROBLEM.npz FOLDER
python -m meshseg_reference mixture FOLDER

SOLVER: jaxopt, nlopt, scipy, numba; for labels of faces gco, meshsegnet, cgal. OUT is an existing folder. An
unknown key is an error that lists the known keys. The number of threads is limited before any numerical library is
loaded.
"""

from __future__ import annotations

import dataclasses
import importlib
import os
import sys
import warnings
from functools import partial
from pathlib import Path
from typing import Any, Literal, get_args, get_origin, get_type_hints

MODULES = {
    "jaxopt": "jaxopt_projected_gradient",
    "nlopt": "nlopt_small",
    "scipy": "scipy_chambolle_pock",
    "numba": "numba_chambolle_pock",
    "gco": "gco_expansion",
    "meshsegnet": "meshsegnet_recipe",
    "cgal": "cgal_expansion",
}
DISCRETE = {"gco", "meshsegnet", "cgal"}
THREAD_VARIABLES = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS")


class UsageError(Exception):
    pass


def limit_threads(count: int) -> None:
    allowed = sorted(os.sched_getaffinity(0))
    if not 1 <= count <= len(allowed):
        raise UsageError(f"--threads={count}: expected 1 to {len(allowed)}, the number of cores available to this process")
    os.sched_setaffinity(0, allowed[:count])
    for variable in THREAD_VARIABLES:
        os.environ[variable] = str(count)
    if count == 1:
        flags = os.environ.get("XLA_FLAGS", "")
        os.environ["XLA_FLAGS"] = f"{flags} --xla_cpu_multi_thread_eigen=false".strip()


def parse_value(kind: Any, key: str, text: str) -> Any:
    """Parses an option value as `kind`, a type annotation of an option class."""
    choices = ("true", "false") if kind is bool else get_args(kind) if get_origin(kind) is Literal else ()
    if choices:
        if text not in choices:
            raise UsageError(f"--{key}={text}: expected {' or '.join(choices)}")
        return text == "true" if kind is bool else text
    try:
        return kind(text)
    except ValueError:
        raise UsageError(f"--{key}={text}: expected a number ({kind.__name__})") from None


def build_options(owner: type[Any], given: dict[str, str]) -> Any:
    """Builds the dataclass `owner` from its keys in `given`, and removes these keys."""
    values = {}
    for name, kind in get_type_hints(owner).items():
        key = name.replace("_", "-")
        if key in given:
            values[name] = parse_value(kind, key, given.pop(key))
    return owner(**values)


def option_names(*owners: type[Any]) -> str:
    return ", ".join(f"--{field.name.replace('_', '-')}" for owner in owners for field in dataclasses.fields(owner))


def solve(name: str, problem_path: Path, folder: Path, arguments: list[str]) -> None:
    given: dict[str, str] = {}
    for argument in arguments:
        key, equals, value = argument.removeprefix("--").partition("=")
        if not (argument.startswith("--") and equals):
            raise UsageError(f"`{argument}`: expected an option of the form --key=value")
        given[key] = value
    if "threads" in given:
        limit_threads(parse_value(int, "threads", given.pop("threads")))

    from meshseg_reference.problem import load_continuous, load_discrete
    from meshseg_reference.trace import Limits, Trace

    module = importlib.import_module(f"meshseg_reference.{MODULES[name]}")
    limits = build_options(Limits, given)
    options = build_options(module.Options, given)
    if given:
        raise UsageError(
            f"{name} has no option --{next(iter(given))}; its options are --threads, {option_names(Limits, module.Options)}"
        )
    if not folder.is_dir():
        raise UsageError(f"{folder}: not an existing folder; create it first")
    problem = (load_discrete if name in DISCRETE else load_continuous)(problem_path)
    module.solve(problem, Trace(folder, limits), options)


def check(problem_path: Path, folder: Path) -> None:
    from meshseg_reference import check
    from meshseg_reference.problem import load_continuous

    check.report(load_continuous(problem_path), folder)


def mixture(folder: Path) -> None:
    from meshseg_reference import mixture

    mixture.report(folder)


def main(arguments: list[str]) -> int:
    warnings.filterwarnings("ignore", message="JAXopt is no longer maintained", category=DeprecationWarning)
    match arguments:
        case ["mixture", folder]:
            task = partial(mixture, Path(folder))
        case ["check", problem_path, folder]:
            task = partial(check, Path(problem_path), Path(folder))
        case [name, problem_path, folder, *rest] if name in MODULES:
            task = partial(solve, name, Path(problem_path), Path(folder), rest)
        case _:
            print(__doc__, file=sys.stderr)
            return 2
    try:
        task()
    except UsageError as error:
        print(f"error: {error}", file=sys.stderr)
        return 2
    except Exception as error:
        print(f"error: {error}" if type(error).__name__ == "InputError" else f"error: {error!r}", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
