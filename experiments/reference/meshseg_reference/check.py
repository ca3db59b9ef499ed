"""Compares results of meshseg with independent code, and prints the differences as JSON.

    FOLDER: u.npy, epsilon_paper.npy, epsilon_intrinsic.npy, gradient_paper.npy, gradient_intrinsic.npy,
            energies.json, q.npy, project_in.npy, project_out.npy (each comparison needs only its own files)

Gradients are computed by jax.grad of the energy in float64, energies with the exported matrices, and
projections by jaxopt.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jaxopt.projection import projection_simplex

from meshseg_reference.energy import EPSILON_MODES, EpsilonMode, delta, dual_bound, energy, face_norms, smoothed_energy
from meshseg_reference.problem import Floats, InputError, Problem

jax.config.update("jax_enable_x64", True)


def autodiff_gradient(problem: Problem, u: Floats, epsilon: float, mode: EpsilonMode) -> Floats:
    entries = problem.K.tocoo()
    spread = jnp.asarray(delta(problem, epsilon, mode))

    def value(v: Any) -> Any:
        gradients = jax.ops.segment_sum(entries.data[:, None] * v[entries.col], entries.row, 2 * len(spread))
        squares = jnp.sum(gradients**2, axis=1).reshape(-1, 2).sum(axis=1)
        return jnp.sum(problem.f * v) + problem.lam * jnp.sum(jnp.sqrt(squares + spread))

    return np.asarray(jax.grad(value)(jnp.asarray(u)))


def relative(a: float, b: float) -> float:
    return abs(a - b) / abs(b)


def compare(problem: Problem, folder: Path) -> dict[str, float]:
    differences: dict[str, float] = {}

    def has(*names: str) -> bool:
        return all((folder / name).exists() for name in names)

    def array(name: str) -> Floats:
        values: Floats = np.load(folder / name, allow_pickle=False)
        return values

    given = json.loads((folder / "energies.json").read_text(encoding="utf-8")) if has("energies.json") else {}
    for mode in EPSILON_MODES:
        if not has("u.npy", f"epsilon_{mode}.npy"):
            continue
        epsilon = float(array(f"epsilon_{mode}.npy"))
        if has(f"gradient_{mode}.npy"):
            reference = autodiff_gradient(problem, array("u.npy"), epsilon, mode)
            worst = np.abs(array(f"gradient_{mode}.npy") - reference).max()
            differences[f"gradient_{mode}"] = float(worst / np.abs(reference).max())
        if f"smoothed_{mode}" in given:
            expected = smoothed_energy(problem, array("u.npy"), epsilon, mode)
            differences[f"smoothed_{mode}"] = relative(given[f"smoothed_{mode}"], expected)
    if has("u.npy") and "energy" in given:
        differences["energy"] = relative(given["energy"], energy(problem, array("u.npy")))
    if has("q.npy") and "dual_bound" in given:
        q = array("q.npy")
        if face_norms(q).max() > problem.lam * (1 + 1e-12):
            raise InputError(f"{folder / 'q.npy'}: the norm of a block exceeds lambda")
        differences["dual_bound"] = relative(given["dual_bound"], dual_bound(problem, q))
    if has("project_in.npy", "project_out.npy"):
        reference = np.asarray(jax.vmap(projection_simplex)(jnp.asarray(array("project_in.npy"))))
        differences["projection"] = float(np.abs(array("project_out.npy") - reference).max())
    return differences


def report(problem: Problem, folder: Path) -> None:
    print(json.dumps(compare(problem, folder)))
