"""Arrays as the compiled part takes them."""

import numpy as np
from numpy.typing import ArrayLike, NDArray


def numbers(name: str, array: ArrayLike) -> NDArray[np.float64]:
    """N x d floats; N numbers become N x 1. Not copied if they are float64 in C order."""
    if np.ma.is_masked(array):
        raise ValueError(f"{name}: is a masked array; fill what is masked, as by {name}.filled(...)")
    given = np.asarray(array)
    if given.dtype.kind not in "fiub":
        raise ValueError(f"{name}: has the type {given.dtype}; it must be an array of numbers")
    if given.ndim == 1:
        given = given[:, np.newaxis]
    if given.ndim != 2:
        raise ValueError(f"{name}: has {given.ndim} axes; it must have 1 or 2")
    return np.ascontiguousarray(given, dtype=np.float64)


def of_files(name: str, array: ArrayLike) -> NDArray[np.float64]:
    """The same, with uint8 divided by 255, as in the files of data."""
    given = numbers(name, array)
    return given / 255.0 if np.asarray(array).dtype == np.uint8 else given


def labels(name: str, array: ArrayLike) -> NDArray[np.float64]:
    """The same of labels, which are no truth values."""
    if np.asarray(array).dtype == bool:
        raise ValueError(f"{name}: has truth values; it must have labels, -1 where there is none")
    return numbers(name, array)
