"""The compiled part."""

from collections.abc import Callable
from os import PathLike
from typing import Any

import numpy as np
from numpy.typing import NDArray

__version__: str

class Mesh:
    """A triangle mesh."""

    def __init__(
        self,
        vertices: NDArray[np.float64],
        faces: NDArray[np.int64],
        colors: NDArray[np.float64] | None = None,
        face_colors: NDArray[np.float64] | None = None,
    ) -> None: ...
    @property
    def vertices(self) -> NDArray[np.float64]: ...
    @property
    def faces(self) -> NDArray[np.uint32]: ...
    @property
    def colors(self) -> NDArray[np.float64] | None: ...
    @property
    def face_colors(self) -> NDArray[np.float64] | None: ...
    @property
    def area(self) -> float: ...
    @property
    def path(self) -> str | None: ...

def read_mesh(path: str | PathLike[str]) -> Mesh: ...
def call(
    arguments: list[str],
    mesh: Mesh | None,
    arrays: list[tuple[str, NDArray[np.float64]]],
    callback: Callable[[int, float, float, float, float], object] | None,
) -> dict[str, Any]: ...
def operators(mesh: Mesh) -> dict[str, Any]: ...
def kmeans(
    data: NDArray[np.float64], weights: NDArray[np.float64], regions: int, seed: int
) -> NDArray[np.float64]: ...
def main(program: list[str], arguments: list[str]) -> int: ...
