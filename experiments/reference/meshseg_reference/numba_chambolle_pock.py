"""Over-relaxed Chambolle-Pock in two compiled loops, one over vertices and one over faces.

    x = Proj_simplex( u - tau (f + K^T q) )                u <- u + rho (x - u)
    y = Proj_{|q_j| <= lambda}( q + sigma K (2x - u) )     q <- q + rho (y - q)

The iterates are (x, y). Step sizes, with s = balance:

    plain      sigma = s lambda / |K|                       tau = 1 / (s lambda |K|)
    diagonal   sigma_j = s lambda / max_i sum_k |K_ik|      tau_k = 1 / (s lambda sum_i |K_ik|),  i in {2j, 2j+1}
    local      sigma_j = s lambda / |K_j|                   tau_k = 1 / sum_j sigma_j b_j |K_jk|^2  (see `curvature`)

Chambolle, Pock: A First-Order Primal-Dual Algorithm for Convex Problems with Applications to Imaging,
JMIV 40, 2011. Pock, Chambolle: Diagonal Preconditioning for First Order Primal-Dual Algorithms in Convex
Optimization, ICCV 2011 (diagonal is their alpha = 1). Condat: A Primal-Dual Splitting Method ..., JOTA 158,
2013 (rho).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numba import njit, prange

from meshseg_reference.curvature import at_vertices, corner_bounds, largest_eigenvalues
from meshseg_reference.energy import project_balls
from meshseg_reference.problem import Floats, Problem
from meshseg_reference.scipy_chambolle_pock import norm
from meshseg_reference.trace import Sample, Trace, drive

LANES = 128
POWER_ITERATIONS = 50
ROUNDING = {"nsz", "contract", "arcp", "reassoc"}  # without nnan and ninf


@dataclass(frozen=True)
class Options:
    steps: Literal["plain", "diagonal", "local"] = "diagonal"
    relaxation: float = 1.9
    balance: float = 2.0
    precision: Literal["f64", "f32"] = "f64"


def step_sizes(problem: Problem, rule: str, balance: float) -> tuple[Floats, Floats]:
    """sigma (F) and tau (V). At a vertex without faces, tau = 1 and only f matters."""
    corners, weights = problem.stencil()
    vertices = len(problem.f)
    if rule == "plain":
        length = norm(problem.K, POWER_ITERATIONS)
        sigma = np.full(len(corners), balance * problem.lam / length)
        return sigma, np.full(vertices, 1 / (balance * problem.lam * length))
    if rule == "diagonal":
        lengths = np.abs(weights).sum(axis=2).max(axis=1)
        resistance = balance * problem.lam * at_vertices(corners, np.abs(weights).sum(axis=1), vertices)
    else:
        lengths = np.sqrt(largest_eigenvalues(weights @ weights.transpose(0, 2, 1)))
    sigma = balance * problem.lam / np.where(lengths > 0, lengths, 1.0)
    if rule == "local":
        resistance = at_vertices(corners, sigma[:, None] * corner_bounds(weights), vertices)
    return sigma, 1 / np.where(resistance > 0, resistance, 1.0)


def compile_iterations(regions: int, real: type[np.floating[Any]]) -> Callable[..., None]:
    """Compiles the loops for one number of regions and one precision, both of which are compile-time constants.

    Indices are unsigned, because numba checks each access with a signed index for a negative value.
    """
    zero, one = real(0), real(1)

    @njit(parallel=True, fastmath=ROUNDING, cache=True)
    def iterate(iterations, u, q, u_next, q_next, ahead, f, tau, sigma, radius, rho, corners, weights, first, faces, back):
        vertices = len(u)
        for _ in range(iterations):
            for block in prange((vertices + LANES - 1) // LANES):
                start = block * LANES
                count = min(LANES, vertices - start)
                z = np.empty((regions, LANES), real)
                sorted_z = np.empty((regions, LANES), real)
                total = np.empty(LANES, real)
                threshold = np.empty(LANES, real)
                slope = np.empty(regions, real)
                for lane in range(count):
                    k = start + lane
                    for p in range(regions):
                        slope[p] = f[k, p]
                    for i in range(first[k], first[k + 1]):
                        j = faces[i]
                        for p in range(regions):
                            slope[p] += back[i, 0] * q[j, 0, p] + back[i, 1] * q[j, 1, p]
                    for p in range(regions):
                        z[p, lane] = sorted_z[p, lane] = u[k, p] - tau[k] * slope[p]
                for end in range(regions - 1, 0, -1):
                    for p in range(end):
                        for lane in range(LANES):
                            a, b = sorted_z[p, lane], sorted_z[p + 1, lane]
                            sorted_z[p, lane], sorted_z[p + 1, lane] = max(a, b), min(a, b)
                for lane in range(LANES):
                    total[lane] = sorted_z[0, lane] - one
                    threshold[lane] = total[lane]
                for p in range(1, regions):
                    share = one / real(p + 1)
                    for lane in range(LANES):
                        total[lane] += sorted_z[p, lane]
                        threshold[lane] = max(threshold[lane], total[lane] * share)
                for lane in range(count):
                    k = start + lane
                    for p in range(regions):
                        x = max(z[p, lane] - threshold[lane], zero)
                        ahead[k, p] = x + x - u[k, p]
                        u_next[k, p] = u[k, p] + rho * (x - u[k, p])
            for j in prange(len(q)):
                a, b, c = corners[j, 0], corners[j, 1], corners[j, 2]
                step = sigma[j]
                a0, b0, c0 = step * weights[j, 0, 0], step * weights[j, 0, 1], step * weights[j, 0, 2]
                a1, b1, c1 = step * weights[j, 1, 0], step * weights[j, 1, 1], step * weights[j, 1, 2]
                square = zero
                for p in range(regions):
                    y0 = q[j, 0, p] + (a0 * ahead[a, p] + b0 * ahead[b, p] + c0 * ahead[c, p])
                    y1 = q[j, 1, p] + (a1 * ahead[a, p] + b1 * ahead[b, p] + c1 * ahead[c, p])
                    square += y0 * y0 + y1 * y1
                shrink = radius / np.sqrt(max(square, radius * radius))
                for p in range(regions):
                    y0 = q[j, 0, p] + (a0 * ahead[a, p] + b0 * ahead[b, p] + c0 * ahead[c, p])
                    y1 = q[j, 1, p] + (a1 * ahead[a, p] + b1 * ahead[b, p] + c1 * ahead[c, p])
                    q_next[j, 0, p] = q[j, 0, p] + rho * (shrink * y0 - q[j, 0, p])
                    q_next[j, 1, p] = q[j, 1, p] + rho * (shrink * y1 - q[j, 1, p])

    compiled: Callable[..., None] = iterate
    return compiled


class ChambollePock:
    def __init__(self, problem: Problem, options: Options) -> None:
        real: type[np.floating[Any]] = np.float32 if options.precision == "f32" else np.float64
        corners, weights = problem.stencil()
        order = np.argsort(corners.ravel(), kind="stable")
        valence = np.bincount(corners.ravel(), minlength=len(problem.f))
        sigma, tau = step_sizes(problem, options.steps, options.balance)
        self.lam = problem.lam
        self.rho = real(options.relaxation)
        self.one = real(1)
        self.u = problem.u0.astype(real, order="C")
        self.q = np.zeros((len(corners), 2, problem.regions), real)
        self.x, self.y = self.u.copy(), self.q.copy()
        self.geometry = (
            corners.astype(np.uint32),
            weights.astype(real),
            np.concatenate([[0], np.cumsum(valence)]).astype(np.uint32),
            (order // 3).astype(np.uint32),
            weights.transpose(0, 2, 1).reshape(-1, 2)[order].astype(real),
        )
        self.constants = (
            np.empty_like(self.u),
            problem.f.astype(real, order="C"),
            tau.astype(real),
            sigma.astype(real),
            real(problem.lam),
        )
        self._iterate = compile_iterations(problem.regions, real)
        self.run(1, self.x, self.y, self.one)

    def run(self, iterations: int, u_next: Any, q_next: Any, rho: Any) -> None:
        self._iterate(iterations, self.u, self.q, u_next, q_next, *self.constants, rho, *self.geometry)

    def advance(self, iterations: int) -> None:
        """Leaves the last iterate (x, y) unrelaxed; `sample` relaxes it, as the loops do in all other iterations."""
        self.run(iterations - 1, self.u, self.q, self.rho)
        self.run(1, self.x, self.y, self.one)

    def sample(self) -> Sample:
        self.u += self.rho * (self.x - self.u)
        self.q += self.rho * (self.y - self.q)
        u = self.x.astype(np.float64)
        q = self.y.reshape(-1, u.shape[1]).astype(np.float64)
        return Sample(u, project_balls(q, self.lam))


def solve(problem: Problem, trace: Trace, options: Options) -> None:
    drive(ChambollePock(problem, options), trace, problem.u0)
