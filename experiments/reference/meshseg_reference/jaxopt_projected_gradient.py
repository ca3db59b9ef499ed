"""Projected gradient on the smoothed energy, with jaxopt.ProjectedGradient in float64.

    v <- P( v - t grad E_eps(v) ),  P = row-wise projection onto the simplex, t = stepsize / L

With acceleration=true this is FISTA (Beck and Teboulle, SIAM J. Imaging Sciences 2, 2009). With
epsilon-start the smoothing decreases (Bot and Hendrich, J. Global Optimization 63, 2015):

    eps_i = max( epsilon, epsilon_start / i^2 ),  t_i = stepsize / L_i,  L_i ~ eps_i^(-1/2)

The variable is v_k = w_k^(1/2) u_k with w_k = sum_j lambda delta_j^(-1/2) b_j |K_jk|^2 (see `curvature`), for
which the gradient has Lipschitz constant L <= 1; precondition=false uses w_k = max w instead, which is plain
projected gradient. stepsize=0 selects jaxopt's line search.

jaxopt: Blondel et al., Efficient and Modular Implicit Differentiation, NeurIPS 2022. It is no longer
developed. The gradient f + K^T q is computed by gathers over the faces of each vertex: XLA's scatter-add,
which autodiff generates for a gather, takes three times as long. The sum over these faces is a scan:
unrolled, XLA fuses it into its consumers and computes it several times.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import reduce
from itertools import accumulate
from typing import Any, Literal

import jax
import jax.numpy as jnp
import jaxopt
import numpy as np
from jaxopt.projection import projection_simplex

from meshseg_reference.curvature import at_vertices, corner_bounds
from meshseg_reference.energy import EpsilonMode, delta
from meshseg_reference.problem import Floats, Indices, Problem
from meshseg_reference.trace import Sample, Trace, drive

jax.config.update("jax_enable_x64", True)


@dataclass(frozen=True)
class Options:
    epsilon: float = 1e-12
    epsilon_start: float = 3e-6
    epsilon_mode: EpsilonMode = "paper"
    acceleration: bool = True
    stepsize: float = 1.0
    precondition: bool = True
    projection: Literal["network", "jaxopt"] = "network"


def faces_of_vertices(corners: Indices, weights: Floats, vertices: int) -> tuple[Indices, Floats]:
    """Faces (V x d) and weights (V x d x 2), padded with weight 0 up to the largest valence d."""
    flat = corners.ravel()
    order = np.argsort(flat, kind="stable")
    valence = np.bincount(flat, minlength=vertices)
    vertex = flat[order]
    slot = np.arange(len(flat)) - np.repeat(np.cumsum(valence) - valence, valence)
    faces = np.zeros((vertices, int(valence.max(initial=1))), np.int32)
    padded = np.zeros((*faces.shape, 2))
    faces[vertex, slot] = order // 3
    padded[vertex, slot] = weights.transpose(0, 2, 1).reshape(-1, 2)[order]
    return faces, padded


def value_and_gradient(problem: Problem, scale: Floats, spread: Floats) -> Callable[[Any, Any], tuple[Any, Any]]:
    """E_eps and its gradient in v = scale u, for delta = spread fade."""
    corners, weights = problem.stencil()
    faces, transposed = faces_of_vertices(corners, weights, len(scale))
    f = jnp.asarray(problem.f / scale[:, None])
    weight = jnp.asarray(weights / scale[corners][:, None, :])
    back = jnp.asarray((transposed / scale[:, None, None]).transpose(1, 2, 0))
    at = [jnp.asarray(corners[:, c]) for c in range(3)]
    around = jnp.asarray(faces.T)
    deltas = jnp.asarray(spread)

    def evaluate(v: Any, fade: Any) -> tuple[Any, Any]:
        ends = [v[k] for k in at]
        g0, g1 = (sum(weight[:, r, c, None] * ends[c] for c in range(3)) for r in range(2))
        radius = jnp.sqrt(jnp.sum(g0 * g0 + g1 * g1, axis=1) + deltas * fade)
        shrink = (problem.lam / radius)[:, None]
        q0, q1 = shrink * g0, shrink * g1

        def add_face(gradient: Any, face: Any) -> Any:
            j, (back0, back1) = face
            return gradient + back0[:, None] * q0[j] + back1[:, None] * q1[j], None

        gradient, _ = jax.lax.scan(add_face, f, (around, back))
        return jnp.sum(f * v) + problem.lam * jnp.sum(radius), gradient

    return evaluate


def simplex_network(v: Any, size: Any) -> Any:
    """Projects rows onto simplices of the given sizes: sorting network, then the threshold max_k (S_k - size) / k."""
    columns = [v[:, p] for p in range(v.shape[1])]
    for end in range(len(columns) - 1, 0, -1):
        for i in range(end):
            a, b = columns[i], columns[i + 1]
            columns[i], columns[i + 1] = jnp.maximum(a, b), jnp.minimum(a, b)
    threshold = reduce(jnp.maximum, [(total - size) / k for k, total in enumerate(accumulate(columns), 1)])
    return jnp.maximum(v - threshold[:, None], 0.0)


class ProjectedGradient:
    def __init__(self, problem: Problem, options: Options) -> None:
        self.options = options
        spread = delta(problem, options.epsilon, options.epsilon_mode)
        corners, weights = problem.stencil()
        bounds = (problem.lam / np.sqrt(spread))[:, None] * corner_bounds(weights)
        curvature = at_vertices(corners, bounds, len(problem.f))
        positive = np.where(curvature > 0, curvature, curvature.max())
        self.scale = np.sqrt(positive if options.precondition else np.full_like(positive, positive.max()))
        size = jnp.asarray(self.scale)
        project = jax.vmap(projection_simplex) if options.projection == "jaxopt" else simplex_network
        solver = jaxopt.ProjectedGradient(
            value_and_gradient(problem, self.scale, spread),
            lambda v, _: project(v, size),
            value_and_grad=True,
            stepsize=(lambda i: options.stepsize * jnp.sqrt(self.fade(i))) if options.stepsize > 0 else 0.0,
            acceleration=options.acceleration,
        )
        self.v = jnp.asarray(problem.u0 * self.scale[:, None])
        self.state = solver.init_state(self.v, None, 1.0)

        def step(_: Any, pair: Any) -> Any:
            v, state = pair
            return tuple(solver.update(v, state, None, self.fade(state.iter_num)))

        def iterate(v: Any, state: Any, iterations: int) -> Any:
            return jax.lax.fori_loop(0, iterations, step, (v, state))

        self._iterate = jax.jit(iterate)
        jax.block_until_ready(self._iterate(self.v, self.state, 1))

    def fade(self, iteration: Any) -> Any:
        """eps_i / epsilon, with iterations counted from zero."""
        return jnp.maximum(1.0, self.options.epsilon_start / self.options.epsilon / (iteration + 1.0) ** 2)

    def advance(self, iterations: int) -> None:
        self.v, self.state = jax.block_until_ready(self._iterate(self.v, self.state, iterations))

    def sample(self) -> Sample:
        u = np.asarray(self.v) / self.scale[:, None]
        epsilon = self.options.epsilon * float(self.fade(self.state.iter_num - 1))
        return Sample(u, None, epsilon, self.options.epsilon_mode)


def solve(problem: Problem, trace: Trace, options: Options) -> None:
    drive(ProjectedGradient(problem, options), trace, problem.u0)
