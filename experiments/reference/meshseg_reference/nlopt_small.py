"""Small instances with NLopt: general nonlinear programming on the smoothed energy.

    minimize E_eps(x),  x = the first m - 1 columns of U,  0 <= x_kp <= 1,  sum_p x_kp <= 1 for each vertex k

The last column is one minus the others. slsqp and mma handle the V inequalities directly; auglag moves
them into an augmented Lagrangian, which L-BFGS minimizes within the bounds. NLopt represents constraints by
a dense Jacobian and slsqp stores dense quadratic programs, so memory is estimated before anything is
allocated. An iteration is one evaluation of E_eps; samples are projected onto the simplex,
because the constraints hold only at the end.

slsqp: Kraft, ACM TOMS 20, 1994. mma: Svanberg, SIAM J. Optimization 12, 2002. auglag: Birgin and
Martinez, Optimization Methods and Software 23, 2008. NLopt: S. G. Johnson, github.com/stevengj/nlopt.
"""

from __future__ import annotations

import sys
from dataclasses import dataclass
from typing import Literal

import nlopt
import numpy as np

from meshseg_reference.energy import EpsilonMode, project_simplex, smoothed_energy, smoothed_gradient
from meshseg_reference.problem import Floats, InputError, Problem
from meshseg_reference.trace import Clock, Sample, Trace

Algorithm = Literal["slsqp", "mma", "auglag"]


@dataclass(frozen=True)
class Options:
    algorithm: Algorithm = "mma"
    epsilon: float = 1e-7
    epsilon_mode: EpsilonMode = "paper"
    memory: float = 2.0


def memory_estimate(algorithm: Algorithm, n: int, constraints: int) -> tuple[float, str]:
    """Gigabytes, and an additional reason for them."""
    if algorithm == "slsqp":
        return 8e-9 * n * (8.5 * n + 5 * constraints), "dense n x n least-squares problems and"
    return 8e-9 * n * 2 * constraints, ""


class Minimization:
    def __init__(self, problem: Problem, trace: Trace, options: Options) -> None:
        self.problem = problem
        self.trace = trace
        self.options = options
        self.evaluations = 0
        self.u = problem.u0
        vertices, free = len(problem.f), problem.regions - 1
        self.shape = (vertices, free)
        gigabytes, what = memory_estimate(options.algorithm, vertices * free, vertices)
        if gigabytes > options.memory:
            raise InputError(
                f"{options.algorithm} stores {what or ''} a dense Jacobian of the constraints: "
                f"n = {vertices * free} unknowns and {vertices} constraints need {gigabytes:.1f} GB, "
                f"more than the limit --memory={options.memory:g}".replace("  ", " ")
            )

    def labels(self, x: Floats) -> Floats:
        first = x.reshape(self.shape)
        return np.hstack([first, 1 - first.sum(axis=1, keepdims=True)])

    def sample(self) -> Sample:
        return Sample(project_simplex(self.u), None, self.options.epsilon, self.options.epsilon_mode)

    def objective(self, x: Floats, gradient: Floats) -> float:
        smoothing = (self.options.epsilon, self.options.epsilon_mode)
        self.u = self.labels(x)
        if self.evaluations > 0 and self.trace.is_due(self.evaluations):
            with self.trace.clock.paused() as seconds:
                self.trace.write(self.evaluations, seconds, self.sample())
        if self.trace.is_over():
            raise nlopt.ForcedStop
        self.evaluations += 1
        if gradient.size:
            slope = smoothed_gradient(self.problem, self.u, *smoothing)
            gradient[:] = (slope[:, :-1] - slope[:, -1:]).ravel()
        return smoothed_energy(self.problem, self.u, *smoothing)

    def excess(self, result: Floats, x: Floats, gradient: Floats) -> None:
        result[:] = x.reshape(self.shape).sum(axis=1) - 1
        if gradient.size:
            gradient[:] = 0
            vertex = np.arange(self.shape[0])
            gradient.reshape(self.shape[0], *self.shape)[vertex, vertex] = 1

    def optimizer(self) -> nlopt.opt:
        n = self.shape[0] * self.shape[1]
        kind = {"slsqp": nlopt.LD_SLSQP, "mma": nlopt.LD_MMA, "auglag": nlopt.AUGLAG}[self.options.algorithm]
        opt = nlopt.opt(kind, n)
        opt.set_min_objective(self.objective)
        opt.set_lower_bounds(np.zeros(n))
        opt.set_upper_bounds(np.ones(n))
        opt.add_inequality_mconstraint(self.excess, np.full(self.shape[0], 1e-10))
        if self.options.algorithm == "auglag":
            inner = nlopt.opt(nlopt.LD_LBFGS, n)
            inner.set_ftol_rel(1e-6)
            opt.set_local_optimizer(inner)
        opt.set_ftol_rel(1e-12)
        return opt

    def run(self) -> None:
        self.trace.write(0, 0.0, Sample(self.problem.u0))
        self.trace.clock = Clock()
        try:
            self.u = self.labels(self.optimizer().optimize(self.problem.u0[:, :-1].ravel()))
        except (nlopt.ForcedStop, nlopt.RoundoffLimited, nlopt.runtime_error) as reason:
            forced = self.trace.is_over()  # auglag reports a forced stop of its inner solver as a failure
            if isinstance(reason, nlopt.runtime_error) and not forced:
                raise InputError(f"nlopt failed after {self.evaluations} evaluations") from None
            print(f"nlopt stopped after {self.evaluations} evaluations: {type(reason).__name__}", file=sys.stderr)
        if self.trace.last < self.evaluations:
            with self.trace.clock.paused() as seconds:
                self.trace.write(self.evaluations, seconds, self.sample())


def solve(problem: Problem, trace: Trace, options: Options) -> None:
    Minimization(problem, trace, options).run()
