"""A solver of one's own, here jaxopt's projected gradient on the smoothed energy, and what it is worth."""

import jax
import jax.numpy as jnp
import numpy as np
from jax.experimental import sparse
from jaxopt import ProjectedGradient
from jaxopt.projection import projection_simplex

import meshseg

jax.config.update("jax_enable_x64", True)
LAMBDA, EPSILON = 0.02, 1e-4

mesh = meshseg.read_mesh("torus:60x40")
costs = np.random.default_rng(0).random((len(mesh.vertices), 3))
K, _, mass, *_, areas = meshseg.operators(mesh)
k, f = sparse.BCOO.from_scipy_sparse(K), jnp.asarray(mass[:, np.newaxis] * costs)


def smoothed_energy(u):
    gradients = ((k @ u).reshape(len(areas), -1) / areas[:, np.newaxis]) ** 2
    return jnp.vdot(f, u) + LAMBDA * jnp.vdot(areas, jnp.sqrt(gradients.sum(axis=1) + EPSILON))


def onto_simplices(u, _):
    return jax.vmap(projection_simplex)(u)


solver = ProjectedGradient(smoothed_energy, onto_simplices, maxiter=300, tol=1e-6)
u = np.asarray(solver.run(jnp.full(f.shape, 1 / 3)).params)
# Rounding leaves the rows off the simplex by some 1e-16.
u = np.maximum(u, 0) / np.maximum(u, 0).sum(axis=1, keepdims=True)

theirs = meshseg.evaluate(mesh, costs, u, LAMBDA, epsilon=EPSILON)
ours = meshseg.solve(mesh, costs, LAMBDA, gap=1e-6)
print(f"jaxopt:  energy {theirs['energy']:.8f}, certified gap {theirs['relative_gap']:.1e}")
print(f"meshseg: energy {ours.energy:.8f}, certified gap {ours.relative_gap:.1e}")
assert theirs["dual_bound"] <= ours.energy <= theirs["energy"] + ours.summary["gap"]
