"""Textbook implementations of energies, gradient, dual bound and projections in NumPy.

    E(U)     = <U, f> + lambda sum_j |(K U)_j|
    E_eps(U) = <U, f> + lambda sum_j r_j,  r_j = sqrt(|(K U)_j|^2 + delta_j),  delta_j = eps/4 (paper)
                                                                               or A_j^2 eps (intrinsic)
    grad E_eps = f + K^T q,  q_j = lambda (K U)_j / r_j
    D(q)     = sum_k min_p (f + K^T q)_kp,  |q_j| <= lambda;  D(q) <= min E <= E(U)

Delaunoy, Fundana, Prados, Heyden: Convex Multi-Region Segmentation on Manifolds, ICCV 2009.
"""

from __future__ import annotations

from typing import Literal, get_args

import numpy as np

from meshseg_reference.problem import Floats, Problem

EpsilonMode = Literal["paper", "intrinsic"]
EPSILON_MODES: tuple[EpsilonMode, ...] = get_args(EpsilonMode)


def face_norms(rows: Floats) -> Floats:
    """|q_j| for each term j, a face or a pair of faces; rows is 2T x m."""
    norms: Floats = np.linalg.norm(rows.reshape(len(rows) // 2, -1), axis=1)
    return norms


def delta(problem: Problem, epsilon: float, mode: EpsilonMode) -> Floats:
    if mode == "paper":
        return np.full(len(problem.corners), epsilon / 4)
    return problem.term_areas**2 * epsilon


def energy(problem: Problem, u: Floats) -> float:
    return float(np.sum(u * problem.f) + problem.lam * face_norms(problem.K @ u).sum())


def smoothed_energy(problem: Problem, u: Floats, epsilon: float, mode: EpsilonMode) -> float:
    radius = np.sqrt(face_norms(problem.K @ u) ** 2 + delta(problem, epsilon, mode))
    return float(np.sum(u * problem.f) + problem.lam * radius.sum())


def smoothed_dual(problem: Problem, u: Floats, epsilon: float, mode: EpsilonMode) -> Floats:
    """The feasible q with which the gradient of the smoothed energy is f + K^T q."""
    gradients = problem.K @ u
    radius = np.sqrt(face_norms(gradients) ** 2 + delta(problem, epsilon, mode))
    dual: Floats = problem.lam * gradients / np.repeat(radius, 2)[:, None]
    return dual


def smoothed_gradient(problem: Problem, u: Floats, epsilon: float, mode: EpsilonMode) -> Floats:
    gradient: Floats = problem.f + problem.K.T @ smoothed_dual(problem, u, epsilon, mode)
    return gradient


def dual_bound(problem: Problem, q: Floats) -> float:
    return float((problem.f + problem.K.T @ q).min(axis=1).sum())


def project_balls(q: Floats, radius: float) -> Floats:
    """Projects each block q_j onto the ball |q_j| <= radius."""
    scale = np.maximum(1.0, face_norms(q) / radius)
    projected: Floats = q / np.repeat(scale, 2)[:, None]
    return projected


def project_simplex(u: Floats) -> Floats:
    """Projects each row onto the unit simplex (sort, then threshold)."""
    descending = -np.sort(-u, axis=1)
    thresholds = (np.cumsum(descending, axis=1) - 1) / np.arange(1, u.shape[1] + 1)
    projected: Floats = np.maximum(u - thresholds.max(axis=1, keepdims=True), 0.0)
    return projected
