"""Alpha-expansion with GCO, the authors' library, from the labels of the smallest costs until no move lowers the energy.

GCO's costs are integers here, with 64 bits: those of the problem, divided by one unit and rounded. The library
accepts terms up to 10^12 (10^7 with 32 bits), so the unit is

    max(largest cost or weight / 10^12, sum of the largest costs of all faces and of all weights / 2^62)

and E(l) is wrong by at most (F + P) / 2 units. Its float64 is no alternative: with rounding in the max-flow, moves
that gain nothing count as progress, and the expansion does not end.

An iteration is one sweep over all labels; the last one finds nothing to change. GCO's own loop until convergence,
which skips labels without progress, takes as long.

Boykov, Veksler, Zabih: Fast Approximate Energy Minimization via Graph Cuts, PAMI 23, 2001. Kolmogorov, Zabih: What
Energy Functions Can Be Minimized via Graph Cuts?, PAMI 26, 2004. Boykov, Kolmogorov: An Experimental Comparison of
Min-Cut/Max-Flow Algorithms for Energy Minimization in Vision, PAMI 26, 2004. Package: bkgco, by an author of GCO.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt
from bkgco import GCO, max_energy_term

from meshseg_reference.potts import Labels, Potts, potts, record
from meshseg_reference.problem import Indices, Problem
from meshseg_reference.trace import Trace

Integers = npt.NDArray[np.signedinteger[Any]]

LARGEST_SUM = 2.0**62


@dataclass(frozen=True)
class Options:
    pass


def unit(energy: Potts) -> float:
    """The cost that becomes 1."""
    largest = max(energy.costs.max(), energy.weights.max(initial=0.0))
    total = energy.costs.max(axis=1).sum() + energy.weights.sum()
    return float(max(largest / max_energy_term(np.int64), total / LARGEST_SUM)) or 1.0


def expansion_sweeps(costs: Integers, pairs: Indices, weights: Integers, start: Labels) -> Iterator[Labels]:
    """The labels after each sweep of alpha-expansion with Potts costs. Types of costs and weights must be equal."""
    faces, regions = costs.shape
    with GCO(faces, regions, costs.dtype) as graph:
        graph.set_data_cost(costs).set_neighbors((pairs[0], pairs[1]), weights).set_labeling(start)
        before, energy = None, graph.compute_energy()
        while energy != before:
            before, energy = energy, graph.expansion(1)
            yield graph.get_labeling()


def solve(problem: Problem, trace: Trace, options: Options) -> None:
    energy = potts(problem)
    one = unit(energy)
    costs, weights = (np.rint(values / one).astype(np.int64) for values in (energy.costs, energy.weights))
    record(trace, problem, expansion_sweeps(costs, energy.pairs, weights, energy.start))
