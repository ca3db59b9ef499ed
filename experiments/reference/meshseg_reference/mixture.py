"""Gaussian regions without a length term, by scikit-learn.

    FOLDER: data.npy (V x d), weights.npy (V), start.json and end.json (mean and covariance of each region),
            costs.npy (V x m, at the start), labels.npy (V, at the end)

At lambda = 0, `segment --model gaussian` is classification EM (Celeux and Govaert, 1992): labels are one-hot, and
the prior of all regions is the same. `GaussianMixture.fit` is EM, with soft labels and estimated priors, and ends
elsewhere. This module makes its own loop from the two halves of scikit-learn that both algorithms share: the log
density, and the parameters for given responsibilities, here the weights of the vertices times their one-hot labels.
"""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import numpy.typing as npt
from sklearn.mixture import GaussianMixture
from sklearn.mixture._gaussian_mixture import _compute_precision_cholesky, _estimate_gaussian_parameters

from meshseg_reference.problem import Floats, InputError

Labels = npt.NDArray[np.intp]

MAX_STEPS = 1000


def log_densities(data: Floats, means: Floats, covariances: Floats) -> Floats:
    """log N(C_k; mu_p, Sigma_p), V x m, each column the score of a mixture of one component."""
    columns = []
    for mean, covariance in zip(means, covariances, strict=True):
        mixture = GaussianMixture(n_components=1)
        mixture.weights_, mixture.means_ = np.ones(1), mean[None]
        mixture.covariances_ = covariance[None]
        mixture.precisions_cholesky_ = _compute_precision_cholesky(mixture.covariances_, "full")
        columns.append(mixture.score_samples(data))
    return np.stack(columns, axis=1)


def classification_em(data: Floats, weights: Floats, means: Floats, covariances: Floats) -> tuple[Floats, Floats, Labels]:
    """The parameters and labels to which the start leads: the labels are those before and after the last step."""
    labels = log_densities(data, means, covariances).argmax(axis=1)
    for _ in range(MAX_STEPS):
        responsibilities = weights[:, None] * np.eye(len(means))[labels]
        # scikit-learn adds 10 machine epsilons to the mass of a region, so masses must not be small.
        responsibilities /= weights.mean()
        _, means, covariances = _estimate_gaussian_parameters(data, responsibilities, 0.0, "full")
        before, labels = labels, log_densities(data, means, covariances).argmax(axis=1)
        if np.array_equal(before, labels):
            return means, covariances, labels
    raise InputError(f"no fixed point after {MAX_STEPS} steps")


def parameters(path: Path) -> tuple[Floats, Floats]:
    regions = json.loads(path.read_text(encoding="utf-8"))
    return np.array([region["mean"] for region in regions]), np.array([region["covariance"] for region in regions])


def difference(ours: Floats, reference: Floats) -> float:
    return float(np.abs(ours - reference).max() / np.abs(reference).max())


def report(folder: Path) -> None:
    """Prints the relative differences and the number of different labels as JSON."""
    data, weights, costs, labels = (
        np.load(folder / f"{name}.npy", allow_pickle=False) for name in ("data", "weights", "costs", "labels")
    )
    start, end = parameters(folder / "start.json"), parameters(folder / "end.json")
    means, covariances, reference = classification_em(data, weights, *start)
    print(
        json.dumps(
            {
                "costs": float((np.abs(costs + log_densities(data, *start)) / (1 + np.abs(costs))).max()),
                "means": difference(end[0], means),
                "covariances": max(difference(*pair) for pair in zip(end[1], covariances, strict=True)),
                "labels": int((labels != reference).sum()),
            }
        )
    )
