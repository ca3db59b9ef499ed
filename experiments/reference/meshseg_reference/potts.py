"""Labels of faces with the Potts energy, for solvers that know labels only.

    E(l) = sum_j f[j, l_j] + sqrt(2) lambda sum_e w_e [l_j != l_k],  e = (j, k)

This is E(U) of the one-hot rows of l, in every relaxation: between two different ones, |(K U)_e| = sqrt(2) w_e in
`frobenius`, and the other relaxations keep the energy of labels.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from meshseg_reference.problem import Floats, Indices, Problem
from meshseg_reference.trace import Clock, Sample, Trace

Labels = npt.NDArray[np.int32]


@dataclass(frozen=True)
class Potts:
    costs: Floats  # F x m, smallest of each row 0
    pairs: Indices  # 2 x P, each pair once, pairs[0] < pairs[1]
    weights: Floats  # P, with the factor sqrt(2) lambda
    start: Labels  # F, labels of the smallest costs


def potts(problem: Problem) -> Potts:
    """Sums the weights of equal pairs. A constant for each row of costs changes no minimizer."""
    faces = len(problem.f)
    ends = np.sort(problem.pairs, axis=1).astype(np.int64)
    keys, index = np.unique(ends[:, 0] * faces + ends[:, 1], return_inverse=True)
    weights = np.sqrt(2) * problem.lam * problem.weights
    return Potts(
        costs=np.ascontiguousarray(problem.f - problem.f.min(axis=1, keepdims=True)),
        pairs=np.stack(np.divmod(keys, faces)).astype(np.int32),
        weights=np.bincount(index, weights=weights, minlength=len(keys)).astype(np.float64),
        start=problem.f.argmin(axis=1).astype(np.int32),
    )


def one_hot(labels: Labels, regions: int) -> Floats:
    return np.eye(regions)[labels]


def record(trace: Trace, problem: Problem, sweeps: Iterator[Labels]) -> None:
    """Writes the labels after each sweep until they end or a limit is reached. Iterate 0 is u0."""
    trace.write(0, 0.0, Sample(problem.u0))
    trace.clock = Clock()
    while not trace.is_over():
        labels = next(sweeps, None)
        if labels is None:
            return
        with trace.clock.paused() as seconds:
            trace.write(trace.last + 1, seconds, Sample(one_hot(labels, problem.regions)))
