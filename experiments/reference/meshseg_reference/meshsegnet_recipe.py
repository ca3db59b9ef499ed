"""The graph cut that MeshSegNet publishes as post-processing of its probabilities p (F x m).

    D[j, l] = int( -100 log10 max(p[j, l], 1e-6) )
    W[j, k] = int( -100 lambda_c beta log10(theta / pi) phi )         faces j and k share an edge
    theta = arccos <n_j, n_k>,  phi = |b_j - b_k|,  beta = 1 if theta > pi / 2, else 1 + |<n_j, n_k>|

with normals n and barycenters b, <n_j, n_k> >= 1 replaced by .9999 in the angle, and int cutting off decimals. Then
alpha-expansion of sum_j D[j, l_j] + sum_jk W[j, k] [l_j != l_k] with GCO, from label 0 everywhere, in at most 5
sweeps, the default of the `cut_from_graph` that the authors call. Here GCO's general graph gets the same 32-bit
integers.

The weights grow with the unit of length while D does not: the authors' meshes are jaws in millimeters, about 60 wide,
and lengths are multiplied by `scale` to compare. Neighbors are the pairs of the problem, once each; the authors find
them by a search in quadratic time, which does not count here. p are recovered from f = -area log p, and a face
without area gets equal ones.

Lian et al.: Deep Multi-Scale Mesh Feature Learning for Automated Labeling of Raw Dental Surfaces from 3D Intraoral
Scanners, IEEE TMI 39, 2020; github.com/Tai-Hsien/MeshSegNet.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import islice

import numpy as np
from bkgco import max_energy_term

from meshseg_reference.gco_expansion import expansion_sweeps
from meshseg_reference.potts import Labels, potts, record
from meshseg_reference.problem import Floats, Indices, InputError, Problem
from meshseg_reference.trace import Trace

ROUND_FACTOR = 100
SMALLEST_PROBABILITY = 1e-6


@dataclass(frozen=True)
class Options:
    lambda_c: float = 30.0
    scale: float = 1.0
    sweeps: int = 5


def probabilities(problem: Problem) -> Floats:
    areas = problem.areas[:, None]
    # The largest exponent of each row is 0, so that no row vanishes.
    excess = problem.f - problem.f.min(axis=1, keepdims=True)
    p: Floats = np.exp(-np.divide(excess, areas, out=np.zeros_like(excess), where=areas > 0))
    p /= p.sum(axis=1, keepdims=True)
    return p


def unaries(problem: Problem) -> Labels:
    return (-ROUND_FACTOR * np.log10(np.maximum(probabilities(problem), SMALLEST_PROBABILITY))).astype(np.int32)


def edge_weights(problem: Problem, pairs: Indices, options: Options) -> Labels:
    a, b, c = (problem.points[problem.faces[:, i]] for i in range(3))
    normals = np.cross(b - a, c - a)
    lengths = np.linalg.norm(normals, axis=1, keepdims=True)
    normals /= np.where(lengths > 0, lengths, 1.0)
    barycenters = (a + b + c) / 3
    j, k = pairs
    cosine = np.sum(normals[j] * normals[k], axis=1)
    theta = np.arccos(np.where(cosine >= 1, 0.9999, np.maximum(cosine, -1.0)))
    phi = options.scale * np.linalg.norm(barycenters[j] - barycenters[k], axis=1)
    beta = np.where(theta > np.pi / 2, 1.0, 1 + np.abs(cosine))
    weights: Floats = -beta * np.log10(theta / np.pi) * phi * options.lambda_c * ROUND_FACTOR
    if (largest := weights.max(initial=0.0)) > (limit := max_energy_term(np.int32)):
        raise InputError(f"a weight of {largest:.3g} exceeds GCO's limit of {limit:,}: lower --scale or --lambda-c")
    return weights.astype(np.int32)


def solve(problem: Problem, trace: Trace, options: Options) -> None:
    pairs = potts(problem).pairs
    weights = edge_weights(problem, pairs, options)
    start = np.zeros(len(problem.f), np.int32)
    record(trace, problem, islice(expansion_sweeps(unaries(problem), pairs, weights, start), options.sweeps))
