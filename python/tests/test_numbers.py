"""Operators against formulas, energies against operators."""

import numpy as np
import pytest

import meshseg


def test_gradients_of_linear_functions(torus):
    K, M, *masses, _, areas = meshseg.operators(torus)
    x = torus.vertices
    corners = x[torus.faces]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    assert np.allclose(areas, np.linalg.norm(normals, axis=1) / 2)
    normals /= np.linalg.norm(normals, axis=1)[:, np.newaxis]
    slope = np.array([0.3, -1.2, 0.7])
    # The gradient on a face is the slope without its part along the normal.
    along = (normals @ slope)[:, np.newaxis] * normals
    tangential = np.linalg.norm(slope - along, axis=1)
    found = np.linalg.norm((K @ (x @ slope)).reshape(-1, 2), axis=1)
    assert np.allclose(found, areas * tangential)
    for mass in masses:
        assert np.isclose(mass.sum(), torus.area)
    assert np.isclose(M.sum(), torus.area)


def test_energy_by_the_operators(torus, costs):
    K, _, mass, _, laplacian, areas = meshseg.operators(torus)
    result = meshseg.solve(torus, costs, 0.05, gap=1e-7)
    tv = np.linalg.norm((K @ result.u).reshape(len(areas), -1), axis=1).sum()
    data = (mass[:, np.newaxis] * costs * result.u).sum()
    assert np.isclose(result.energy, data + 0.05 * tv, rtol=1e-12)
    weighted = np.repeat(1 / areas, 2)[:, np.newaxis] * K.toarray()
    assert np.allclose(laplacian.toarray(), K.T @ weighted)


def test_bound_by_the_operators(torus, costs):
    K, _, mass, *_ = meshseg.operators(torus)
    result = meshseg.solve(torus, costs, 0.05, gap=1e-7, save="q")
    q = result.q.reshape(len(torus.faces), -1)
    assert np.linalg.norm(q, axis=1).max() <= 0.05 * (1 + 1e-12)
    bound = (mass[:, np.newaxis] * costs + K.T @ result.q).min(axis=1).sum()
    assert np.isclose(result.dual_bound, bound, rtol=1e-12)


def test_clusters():
    data = np.r_[np.zeros((5, 2)), np.ones((3, 2)), np.full((2, 2), 9.0)]
    centers, nearest = meshseg.kmeans(data, 3, seed=4)
    assert sorted(centers[:, 0]) == [0, 1, 9]
    assert np.array_equal(centers[nearest], data)
    weighted, _ = meshseg.kmeans([0.0, 1.0, 50.0], 2, weights=[3, 1, 1])
    assert np.isclose(sorted(weighted[:, 0]), [0.25, 50]).all()
    for wrong in ({"weights": [1, 2]}, {"weights": [0, 0, 0]}, {"regions": 1}):
        with pytest.raises(ValueError):
            meshseg.kmeans([0.0, 1.0, 2.0], **({"regions": 2} | wrong))
    with pytest.raises(ValueError, match="data: must be finite"):
        meshseg.kmeans([np.nan, 0.0], 2)


def test_labels_of_faces_by_their_edges(torus):
    costs = np.random.default_rng(5).random((len(torus.faces), 3))
    result = meshseg.solve(torus, costs, 0.02, on="faces", gap=1e-6)
    assert result.u.shape == costs.shape and result.face_labels.shape == (len(costs),)
    found = meshseg.evaluate(torus, costs, result.u, 0.02, on="faces")
    assert np.isclose(found["energy"], result.energy, rtol=1e-12)
    # Lengths of the edges between two faces with different labels.
    sides = np.sort(torus.faces[:, [[1, 2], [2, 0], [0, 1]]].reshape(-1, 2), axis=1)
    edges, edge_of_side = np.unique(sides, axis=0, return_inverse=True)
    order = np.argsort(edge_of_side.ravel(), kind="stable").reshape(len(edges), 2)
    left, right = (result.face_labels[order[:, side] // 3] for side in (0, 1))
    x = torus.vertices
    lengths = np.linalg.norm(x[edges[:, 1]] - x[edges[:, 0]], axis=1)
    corners = x[torus.faces]
    areas = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1) / 2
    data = (areas * costs[np.arange(len(costs)), result.face_labels]).sum()
    # |K U| of two different regions is sqrt 2.
    energy = data + 0.02 * 2**0.5 * lengths[left != right].sum()
    assert np.isclose(energy, result.summary["rounded_energy"], rtol=1e-12)
