"""What ``segment`` and ``solve`` return."""

import json
import math
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ._words import pythonic

if TYPE_CHECKING:
    import pandas


class MeshsegWarning(UserWarning):
    """What a result does not do as its user might expect: a sentence with what to do next."""


class History(dict[str, NDArray[Any]]):
    """The samples of a run, a column each: ``iteration``, ``seconds``, ``energy``, ``dual_bound``, ``gap``,
    ``relative_gap``, ``change``. Bounds are those of the iterates; evaluations do not count in ``seconds``."""

    def frame(self) -> "pandas.DataFrame":
        """The same as a table of pandas."""
        import pandas

        return pandas.DataFrame(dict(self))

    def __repr__(self) -> str:
        return f"History({len(self.get('iteration', ()))} samples: {', '.join(self)})"


class Result:
    """Labels with their certificate. Printed, it is the report of the command line.

    >>> import meshseg
    >>> result = meshseg.segment("builtin:spot", regions=3)
    >>> bool(result.history["relative_gap"][-1] == result.relative_gap)
    True
    >>> result.dual_bound <= result.energy <= result.rounded_energy
    True
    """

    #: (V,) int32: a region for each vertex, from 0; -1 where a mask leaves it out.
    labels: NDArray[np.int32]
    #: (F,) int32: the same for each face, for class probabilities; else None.
    face_labels: NDArray[np.int32] | None
    #: (V, m) or, for labels of faces, (F, m): the U of least energy found, rows in the simplex.
    u: NDArray[np.float64]
    #: (2F, m): the dual field of ``dual_bound``, rows 2j and 2j + 1 those of face j, with ``save="q"``; else None.
    q: NDArray[np.float64] | None
    #: The samples of the run.
    history: History
    #: All numbers, as in ``summary.json`` of the command line.
    summary: dict[str, Any]
    #: What a user should know, a sentence each; raised as warnings as well.
    warnings: list[str]
    #: What was done to the input, a sentence each.
    notes: list[str]
    #: The report.
    report: str

    def __init__(self, heard: dict[str, Any]) -> None:
        self.labels = heard["labels"]
        self.face_labels = heard["face_labels"]
        self.u = heard["u"]
        self.q = heard["q"]
        self.history = History(heard["history"])
        self.summary = json.loads(heard["summary"])
        self.summary["warnings"] = [pythonic(sentence) for sentence in self.summary["warnings"]]
        self.warnings = [pythonic(sentence) for sentence in heard["warnings"]]
        self.notes = [pythonic(sentence) for sentence in heard["notes"]]
        self.report = pythonic(heard["printed"])

    @property
    def status(self) -> str:
        """How the run ended: ``converged``, ``iteration-limit``, ``time-limit``, ``interrupted``, ..."""
        return self.summary["status"]

    @property
    def lambda_(self) -> float:
        """The weight of the length of the cuts."""
        return self.summary["lambda"]

    @property
    def energy(self) -> float:
        """E of ``u``."""
        return self.summary["energy"]

    @property
    def dual_bound(self) -> float:
        """D: no U has a smaller energy."""
        return self.summary["dual_bound"]

    @property
    def relative_gap(self) -> float:
        """(E - D) / (E - B), with the sum B of the minimum costs."""
        return self.summary["relative_gap"]

    @property
    def rounded_energy(self) -> float:
        """The energy of the labels."""
        return self.summary["rounded_energy"]

    @property
    def label_gap(self) -> float:
        """The labels are at most this share above any labeling; infinite where no such share is known."""
        gap = self.summary["rounded_relative_gap"]
        return math.inf if gap is None else gap

    @property
    def regions(self) -> list[dict[str, Any]]:
        """The regions of ``segment``: parameters, color, area and share."""
        return self.summary.get("region_parameters", [])

    def __repr__(self) -> str:
        return self.report.rstrip("\n")
