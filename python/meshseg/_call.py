"""A call of a verb: keywords become the options of the command line, arrays stay in memory."""

import csv
import os
import tempfile
import warnings
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from . import _meshseg
from ._arrays import labels, numbers, of_files
from ._meshes import MeshLike, as_mesh
from ._result import MeshsegWarning
from ._words import array_name, in_our_words, name_of, pythonic

#: Options whose value may be an array, by what their arrays are.
_ARRAYS: dict[str, Callable[[str, Any], Any]] = {
    **dict.fromkeys(["costs", "probabilities", "scores", "mask", "edge_aware", "pairs", "u", "q"], numbers),
    **dict.fromkeys(["seeds", "labels_in"], labels),
    **dict.fromkeys(["data", "means"], of_files),
}
#: Options without a value.
_FLAGS = ("components", "contours", "coarse_to_fine", "no_preview")
#: Options with several values after commas.
_LISTS = ("thresholds", "light", "view")


def heard(
    verb: str,
    mesh: MeshLike,
    options: Mapping[str, Any],
    callback: Callable[..., object] | None = None,
) -> dict[str, Any]:
    """What a verb says and finds. ``options`` are keywords; those that are None are left out."""
    arguments: list[str] = []
    arrays: list[tuple[str, Any]] = []
    names = options.get("classes")
    if names is None or isinstance(names, (str, bytes, os.PathLike)):
        file = None
    else:
        file = _class_list(names)
        options = {**options, "classes": file.name}
    try:
        for keyword, value in options.items():
            if value is not None:
                arguments += _words(verb, keyword, value, arrays)
        held = None if isinstance(mesh, (str, bytes, os.PathLike)) else as_mesh(mesh)._held
        path = _path("mesh", mesh) if held is None else os.fspath(held.path or "mesh")
        found = _meshseg.call([verb, *arguments, "--", path], held, arrays, callback)
    finally:
        if file is not None:
            file.close()
    if "error" in found:
        error = found["error"]
        if file is not None and file.name in str(error):
            error = type(error)(str(error).replace(file.name, "classes"))
        raise in_our_words(error)
    for sentence in found["warnings"]:
        warnings.warn(pythonic(sentence), MeshsegWarning, stacklevel=3)
    return found


def _words(verb: str, keyword: str, value: Any, arrays: list[tuple[str, Any]]) -> list[str]:
    """The words of an option; its array, if it has one, is added to the others."""
    name = f"--{name_of(keyword)}"
    is_array = keyword in _ARRAYS or (verb == "solve" and keyword == "init")
    if keyword == "weld" and isinstance(value, (bool, np.bool_)):
        # Only segment welds unless it is told not to.
        return [name] if value else ["--no-weld"] * (verb == "segment")
    if keyword in _FLAGS:
        if not isinstance(value, (bool, np.bool_)):
            raise TypeError(f"{keyword}: must be True or False, not {value!r}")
        return [name] * bool(value)
    if is_array and not isinstance(value, (str, bytes, os.PathLike)):
        arrays.append((array_name(keyword), _ARRAYS.get(keyword, numbers)(keyword, value)))
        return [f"{name}={array_name(keyword)}"]
    if isinstance(value, Mapping):
        return [f"{name}={key.replace('_', '-')}={_text(keyword, value[key])}" for key in value]
    if keyword in _LISTS and isinstance(value, Iterable) and not isinstance(value, str):
        return [f"{name}={','.join(_text(keyword, part) for part in value)}"]
    if isinstance(value, Iterable) and not isinstance(value, (str, bytes)):
        return [f"{name}={_text(keyword, part)}" for part in value]
    return [f"{name}={_text(keyword, value)}"]


def _path(keyword: str, value: Any) -> str:
    return os.fsdecode(value)


def _text(keyword: str, value: Any) -> str:
    """A value as it is typed; floats with all their digits."""
    match value:
        case bool() | np.bool_() if keyword != "solver_options":
            raise TypeError(f"{keyword}: must have a value, not {value!r}")
        case bool() | np.bool_():
            return str(bool(value)).lower()
        case int() | np.integer():
            return str(int(value))
        case float() | np.floating():
            return repr(float(value))
        case str():
            return value
        case bytes() | os.PathLike():
            return _path(keyword, value)
    raise TypeError(f"{keyword}: must be a text, a number or a path, not {type(value).__name__}")


def _class_list(classes: Any) -> Any:
    """Names, or pairs of a name and a color, as a file."""
    if isinstance(classes, Mapping):
        classes = list(classes.items())
    if isinstance(classes, (set, frozenset)):
        raise TypeError("classes: must be in the order of the columns; a set has none")
    rows = [(name, "") if isinstance(name, str) else name for name in classes]
    if not all(isinstance(row, (tuple, list)) for row in rows) or not all(len(row) == 2 and all(isinstance(part, str) for part in row) for row in rows):
        raise TypeError("classes: must be names, or pairs of a name and a color such as #cc8844")
    file = tempfile.NamedTemporaryFile("w", suffix=".csv", newline="", encoding="utf-8")
    written = csv.writer(file)
    written.writerow(["name", "color"])
    written.writerows(rows)
    file.flush()
    return file
