"""A straightforward implementation of Chambolle-Pock with sparse products.

    u' = Proj_simplex( u - tau (f + K^T q) )
    q' = Proj_{|q_j| <= 1}( q + sigma K (2 u' - u) ),   tau = sigma = 1 / |K|

Here K stands for lambda K: with lambda in the radius instead, equal step sizes fit the two variables so
badly that the method takes a hundred times as many iterations. |K| is estimated by power iteration before
the clock starts.

Chambolle, Pock: A First-Order Primal-Dual Algorithm for Convex Problems with Applications to Imaging,
JMIV 40, 2011.
"""

from __future__ import annotations

import sys
import time
from dataclasses import dataclass
from typing import Any

import numpy as np

from meshseg_reference.energy import project_balls, project_simplex
from meshseg_reference.problem import Problem
from meshseg_reference.trace import Sample, Trace, drive


@dataclass(frozen=True)
class Options:
    power_iterations: int = 50


def norm(K: Any, iterations: int) -> float:
    """Estimate of the largest singular value from below, plus one percent."""
    x = np.random.default_rng(0).standard_normal(K.shape[1])
    for _ in range(iterations):
        x = K.T @ (K @ x)
        x /= np.linalg.norm(x)
    return 1.01 * float(np.linalg.norm(K @ x))


class ChambollePock:
    def __init__(self, problem: Problem, options: Options) -> None:
        self.lam = problem.lam
        self.f = problem.f
        self.K = problem.lam * problem.K
        self.Kt = self.K.T.tocsr()
        started = time.perf_counter()
        self.step = 1 / norm(self.K, options.power_iterations)
        seconds = time.perf_counter() - started
        print(f"set-up: {seconds:.3f} s for {options.power_iterations} power iterations", file=sys.stderr)
        self.u = problem.u0
        self.q = np.zeros((self.K.shape[0], problem.regions))

    def advance(self, iterations: int) -> None:
        for _ in range(iterations):
            u = project_simplex(self.u - self.step * (self.f + self.Kt @ self.q))
            self.q = project_balls(self.q + self.step * (self.K @ (2 * u - self.u)), 1.0)
            self.u = u

    def sample(self) -> Sample:
        return Sample(self.u, self.lam * self.q)


def solve(problem: Problem, trace: Trace, options: Options) -> None:
    drive(ChambollePock(problem, options), trace, problem.u0)
