"""Diagonal bounds of K_j^T K_j for each face j.

    K_j^T K_j <= diag_k( b_j |K_jk|^2 ),  b_j = largest eigenvalue of sum_k g_k g_k^T,
                                          g_k = direction of column k of K_j

because |K_j x|^2 = |sum_k g_k (|K_jk| x_k)|^2 <= b_j sum_k |K_jk|^2 x_k^2. Here b_j is 1.5 for an
equilateral face and at most 3; Pock and Chambolle (2011) bound each row of K separately.
"""

from __future__ import annotations

import numpy as np

from meshseg_reference.problem import Floats, Indices


def largest_eigenvalues(matrices: Floats) -> Floats:
    """Largest eigenvalues of symmetric 2 x 2 matrices (F x 2 x 2)."""
    a, b, c = matrices[:, 0, 0], matrices[:, 0, 1], matrices[:, 1, 1]
    top: Floats = (a + c) / 2 + np.hypot((a - c) / 2, b)
    return top


def corner_bounds(weights: Floats) -> Floats:
    """b_j |K_jk|^2 (F x 3)."""
    squares = np.sum(weights**2, axis=1)
    directions = weights / np.sqrt(np.where(squares > 0, squares, 1.0))[:, None, :]
    overlap = largest_eigenvalues(directions @ directions.transpose(0, 2, 1))
    bounds: Floats = overlap[:, None] * squares
    return bounds


def at_vertices(corners: Indices, values: Floats, vertices: int) -> Floats:
    """Sums the values of corners (F x 3) at their vertices."""
    return np.bincount(corners.ravel(), weights=values.ravel(), minlength=vertices).astype(np.float64)
