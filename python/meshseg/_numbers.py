"""Operators and k-means."""

import warnings
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _meshseg
from ._arrays import numbers
from ._meshes import MeshLike, as_mesh
from ._result import MeshsegWarning
from ._words import said

if TYPE_CHECKING:
    from scipy.sparse import csr_matrix


class Operators(NamedTuple):
    """The matrices of a mesh with V vertices and F faces that have an area."""

    #: (2F, V): rows 2j and 2j + 1 are A_j times the gradient on face j, along its first edge and across it.
    K: "csr_matrix"
    #: (V, V): the consistent mass matrix, of piecewise linear functions.
    M: "csr_matrix"
    #: (V,): a third of the area of the faces around each vertex.
    mass_barycentric: NDArray[np.float64]
    #: (V,): the mixed Voronoi areas.
    mass_voronoi: NDArray[np.float64]
    #: (V, V): K^T A^-1 K, the stiffness matrix of the cotangent Laplacian.
    laplacian: "csr_matrix"
    #: (F,): A_j.
    face_areas: NDArray[np.float64]


def operators(mesh: MeshLike) -> Operators:
    """Gradient, masses and Laplacian of a mesh, as matrices of SciPy.

    >>> K, M, *_ = operators("torus:40x25")
    >>> K.shape, M.shape
    ((4000, 1000), (1000, 1000))
    """
    from scipy.sparse import csr_matrix

    held = as_mesh(mesh)._held
    with said():
        found = _meshseg.operators(held)
    for sentence in found.pop("warnings"):
        warnings.warn(sentence, MeshsegWarning, stacklevel=2)

    def matrix(name: str) -> Any:
        *parts, shape = found[name]
        return csr_matrix(tuple(parts), shape=shape)

    matrices = {name: matrix(name) for name in ("K", "M", "laplacian")}
    return Operators(**(found | matrices))


def kmeans(
    data: ArrayLike, regions: int, *, weights: ArrayLike | None = None, seed: int = 0
) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Weighted k-means of N x d data: the (regions, d) centers, fewer if there are fewer different rows, and the nearest of
    them for each row.

    ``weights`` are N numbers, such as the areas of vertices, by default all 1. Seeding is by k-means++; the same seed
    gives the same centers.

    >>> centers, nearest = kmeans([0.0, 0.1, 5.0, 5.1], 2)
    >>> sorted(centers[:, 0].round(6).tolist())
    [0.05, 5.05]
    >>> bool(nearest[0] == nearest[1] != nearest[2] == nearest[3])
    True
    """
    rows = numbers("data", data)
    w = np.ones(len(rows)) if weights is None else numbers("weights", weights).ravel()
    with said():
        centers = _meshseg.kmeans(rows, w, regions, seed)
    distances = np.stack([np.square(rows - center).sum(axis=1) for center in centers])
    return centers, distances.argmin(axis=0)
