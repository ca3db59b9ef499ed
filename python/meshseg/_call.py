"""A call of a verb: keywords become the options of the command line, arrays stay in memory."""

import csv
import os
import tempfile
import warnings
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from . import _meshseg
from ._arrays import numbers, of_files
from ._meshes import MeshLike, as_mesh
from ._result import MeshsegWarning
from ._words import name_of, pythonic, said

#: Options whose value may be an array, by what their arrays are. uint8 is divided by 255 where it is data.
_ARRAYS: dict[str, Callable[[str, Any], Any]] = {
    name: numbers
    for name in (
        "costs init seeds probabilities scores labels_in mask edge_aware u q".split()
    )
} | {"data": of_files, "means": of_files}
#: Options with several values after commas.
_LISTS = ("thresholds", "light")


def heard(
    verb: str,
    mesh: MeshLike,
    options: Mapping[str, Any],
    callback: Callable[..., object] | None = None,
) -> dict[str, Any]:
    """What a verb says and finds. ``options`` are keywords; those that are None are left out."""
    arguments, arrays = [verb], []
    held = None
    match mesh:
        case str() | os.PathLike():
            arguments.append(os.fspath(mesh))
        case _:
            held = as_mesh(mesh)._held
            arguments.append(os.fspath(held.path or "mesh"))
    with tempfile.TemporaryDirectory(prefix="meshseg-") as folder:
        for keyword, value in options.items():
            if value is None:
                continue
            name = f"--{name_of(keyword)}"
            if keyword == "weld" and value is False:
                arguments.append("--no-weld")
            elif isinstance(value, (bool, np.bool_)):
                arguments += [name] * bool(value)
            elif keyword == "classes" and not isinstance(value, (str, os.PathLike)):
                arguments.append(f"{name}={_class_list(value, Path(folder))}")
            elif keyword in _ARRAYS and not isinstance(value, (str, os.PathLike)):
                array = f"<{keyword}>.npy"
                arrays.append((array, _ARRAYS[keyword](keyword, value)))
                arguments.append(f"{name}={array}")
            elif isinstance(value, Mapping):
                arguments += [f"{name}={key}={_text(value[key])}" for key in value]
            elif keyword in _LISTS and not isinstance(value, str):
                arguments.append(f"{name}={','.join(map(_text, value))}")
            elif isinstance(value, (list, tuple)):
                arguments += [f"{name}={_text(part)}" for part in value]
            else:
                arguments.append(f"{name}={_text(value)}")
        with said():
            found = _meshseg.call(arguments, held, arrays, callback)
    for sentence in found["warnings"]:
        warnings.warn(pythonic(sentence), MeshsegWarning, stacklevel=3)
    return found


def _text(value: Any) -> str:
    """A value as it is typed; floats with all their digits."""
    match value:
        case bool() | np.bool_():
            return str(bool(value)).lower()
        case float() | np.floating():
            return repr(float(value))
        case os.PathLike():
            return os.fspath(value)
        case _:
            return str(value)


def _class_list(classes: Sequence[str | tuple[str, str]], folder: Path) -> Path:
    """Names, or pairs of a name and a color, as a file."""
    file = folder / "classes.csv"
    with file.open("w", newline="", encoding="utf-8") as out:
        rows = csv.writer(out)
        rows.writerow(["name", "color"])
        rows.writerows([name, ""] if isinstance(name, str) else name for name in classes)
    return file
