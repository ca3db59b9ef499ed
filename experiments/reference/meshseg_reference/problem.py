"""The problem, as `meshseg problem export` writes it (format 1).

    E(U) = <U, f> + lambda sum_j |(K U)_j|        row k of U in the unit simplex

Rows 2j and 2j+1 of K belong to term j, so (K U)_j is a 2 x m block. Rows of U belong to the vertices of the mesh
and terms to its faces, or rows to the faces and terms to pairs of them. Only the corners of term j have entries in
its rows: those of the face, or the two faces of the pair.

The norm is that of all regions together in the relaxation `frobenius`, the only one that the solvers for U know.
Labels of faces have the same energy in all relaxations (see `potts`).
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal, get_args

import numpy as np
import numpy.typing as npt
import scipy.sparse as sparse

Floats = npt.NDArray[np.float64]
Indices = npt.NDArray[np.int32]
Element = Literal["vertices", "faces"]

FORMAT = b"meshseg-problem"
VERSION = 1
RELAXATION = "frobenius"


class InputError(Exception):
    """An error that the user can correct; only its message is printed."""


@dataclass(frozen=True)
class Problem:
    """n rows of U, for V vertices or F faces, and T terms, for F faces or P pairs."""

    on: Element
    points: Floats  # V x 3
    faces: Indices  # F x 3
    pairs: Indices  # P x 2, no rows on vertices
    weights: Floats  # P, lengths of edges
    K: Any  # 2T x n, CSR
    M: Any  # n x n, CSR: the consistent mass, or the areas on the diagonal
    areas: Floats  # F
    mass_barycentric: Floats | None  # V, None on faces
    mass_voronoi: Floats | None  # V, None on faces
    f: Floats  # n x m
    lam: float
    relaxation: str
    u0: Floats  # n x m

    @property
    def regions(self) -> int:
        return int(self.f.shape[1])

    @property
    def corners(self) -> Indices:
        """Rows of U that term j depends on (T x 3); those of a pair are j, k, k."""
        return self.faces if self.on == "vertices" else self.pairs[:, [0, 1, 1]]

    @property
    def term_areas(self) -> Floats:
        """Areas of the terms (T): a pair has a third of each of its faces."""
        if self.on == "vertices":
            return self.areas
        areas: Floats = np.maximum(self.areas[self.pairs].sum(axis=1) / 3, np.finfo(np.float64).tiny)
        return areas

    def stencil(self) -> tuple[Indices, Floats]:
        """Corners (T x 3) and weights (T x 2 x 3) with (K U)_j = weights[j] @ U[corners[j]]."""
        corners = self.corners
        entries = self.K.tocoo()
        term, row = np.divmod(entries.row, 2)
        is_corner = corners[term] == entries.col[:, None]
        if not is_corner.any(axis=1).all():
            element, term_name = ("vertex", "face") if self.on == "vertices" else ("face", "pair")
            raise InputError(f"K has an entry at a {element} that is not a corner of its {term_name}")
        weights = np.zeros((len(corners), 2, 3))
        # The first of equal corners takes the entry, so that it counts once.
        np.add.at(weights, (term, row, is_corner.argmax(axis=1)), entries.data)
        return corners, weights


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

    def word(name: str, default: str) -> str:
        """Archives of earlier versions lack some words."""
        return bytes(data[name].item()).decode() if name in data else default

    on = next((element for element in get_args(Element) if element == word("on", "vertices")), None)
    if on is None:
        raise InputError(f"{path}: `on` is {word('on', '')!r}, expected one of {', '.join(get_args(Element))}")

    def csr(name: str) -> Any:
        parts = (data[f"{name}_data"], data[f"{name}_indices"], data[f"{name}_indptr"])
        return sparse.csr_array(parts, shape=tuple(int(n) for n in data[f"{name}_shape"]))

    vertices = on == "vertices"
    try:
        problem = Problem(
            on=on,
            points=data["points"],
            faces=data["faces"],
            pairs=np.empty((0, 2), np.int32) if vertices else data["pairs"],
            weights=np.empty(0) if vertices else data["weights"],
            K=csr("K"),
            M=csr("M"),
            areas=data["areas"],
            mass_barycentric=data["mass_barycentric"] if vertices else None,
            mass_voronoi=data["mass_voronoi"] if vertices else None,
            f=data["f"],
            lam=float(data["lambda"]),
            relaxation=word("relaxation", RELAXATION),
            u0=data["u0"],
        )
    except KeyError as error:
        raise InputError(f"{path}: the array `{error.args[0]}` is missing") from error
    if problem.K.shape != (2 * len(problem.corners), len(problem.f)):
        term, element = ("face", "vertex") if vertices else ("pair", "face")
        raise InputError(f"{path}: K has shape {problem.K.shape}, expected two rows per {term} and one column per {element}")
    return problem


def load_continuous(path: Path) -> Problem:
    """A problem for the solvers for U."""
    problem = load(path)
    if problem.relaxation != RELAXATION:
        raise InputError(f"{path}: the relaxation is {problem.relaxation!r}, but only {RELAXATION!r} is supported")
    return problem


def load_discrete(path: Path) -> Problem:
    """A problem for the solvers for labels of faces."""
    problem = load(path)
    if problem.on != "faces":
        raise InputError(f"{path}: this solver finds labels of faces; export the problem with --on faces")
    if len(problem.f) != len(problem.faces):
        raise InputError(f"{path}: f has {len(problem.f)} rows, expected one per face ({len(problem.faces)})")
    return problem
