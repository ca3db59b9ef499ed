"""The problem, as `meshseg problem export` writes it (format 1).

    E(U) = <U, f> + lambda sum_j |(K U)_j|        row k of U in the unit simplex

The norm is that of all regions together; problems in other relaxations are refused.

Rows 2j and 2j+1 of K belong to face j, so (K U)_j is a 2 x m block. Only the corners of face j
have entries there.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import scipy.sparse as sparse

Floats = npt.NDArray[np.float64]
Indices = npt.NDArray[np.int32]

FORMAT = b"meshseg-problem"
VERSION = 1
RELAXATION = b"frobenius"


class InputError(Exception):
    """An error that the user can correct; only its message is printed."""


@dataclass(frozen=True)
class Problem:
    points: Floats  # V x 3
    faces: Indices  # F x 3
    K: Any  # 2F x V, CSR
    M: Any  # V x V, CSR, the consistent mass
    areas: Floats  # F
    mass_barycentric: Floats  # V
    mass_voronoi: Floats  # V
    f: Floats  # V x m
    lam: float
    u0: Floats  # V x m

    @property
    def regions(self) -> int:
        return int(self.f.shape[1])

    def stencil(self) -> tuple[Indices, Floats]:
        """Corners (F x 3) and weights (F x 2 x 3) with (K U)_j = weights[j] @ U[corners[j]]."""
        entries = self.K.tocoo()
        face, row = np.divmod(entries.row, 2)
        is_corner = self.faces[face] == entries.col[:, None]
        if not is_corner.any(axis=1).all():
            raise InputError("K has an entry at a vertex that is not a corner of its face")
        weights = np.zeros((len(self.faces), 2, 3))
        np.add.at(weights, (face, row, is_corner.argmax(axis=1)), entries.data)
        return self.faces, weights


def load(path: Path) -> Problem:
    try:
        archive = np.load(path, allow_pickle=False)
        if not isinstance(archive, np.lib.npyio.NpzFile):
            raise ValueError("a single array")
        with archive:
            data = dict(archive)
    except (OSError, ValueError) as error:
        raise InputError(f"{path}: not a readable .npz file") from error
    form = bytes(data["format"].item()) if "format" in data else b""
    if form != FORMAT:
        raise InputError(f"{path}: `format` is {form!r}, expected {FORMAT!r}; write the file with `meshseg problem export`")
    if int(data.get("version", np.int64(0))) != VERSION:
        raise InputError(f"{path}: format version {data.get('version')}, but this package reads version {VERSION}")
    # Archives of earlier versions have no relaxation.
    relaxation = bytes(data["relaxation"].item()) if "relaxation" in data else RELAXATION
    if relaxation != RELAXATION:
        raise InputError(f"{path}: the relaxation is {relaxation.decode()!r}; this package solves {RELAXATION.decode()!r} only")

    def csr(name: str) -> Any:
        parts = (data[f"{name}_data"], data[f"{name}_indices"], data[f"{name}_indptr"])
        return sparse.csr_array(parts, shape=tuple(int(n) for n in data[f"{name}_shape"]))

    try:
        problem = Problem(
            points=data["points"],
            faces=data["faces"],
            K=csr("K"),
            M=csr("M"),
            areas=data["areas"],
            mass_barycentric=data["mass_barycentric"],
            mass_voronoi=data["mass_voronoi"],
            f=data["f"],
            lam=float(data["lambda"]),
            u0=data["u0"],
        )
    except KeyError as error:
        raise InputError(f"{path}: the array `{error.args[0]}` is missing") from error
    if problem.K.shape != (2 * len(problem.faces), len(problem.f)):
        raise InputError(f"{path}: K has shape {problem.K.shape}, expected two rows per face and one column per vertex")
    return problem
