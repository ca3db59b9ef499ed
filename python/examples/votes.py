"""Labels of faces from votes, as photogrammetry has them: eight views each say a class for the faces they see."""

import numpy as np

import meshseg

CLASSES = ["ground", "wall", "roof", "tree"]

mesh = meshseg.read_mesh("torus:200x125")
rng = np.random.default_rng(0)
centers = mesh.vertices[mesh.faces].mean(axis=1)
around = np.arctan2(centers[:, 1], centers[:, 0])
truth = ((around + np.pi) / (2 * np.pi) * 8).astype(int) % 4

# A view is right in three of five cases, and sees two of three faces.
votes = np.zeros((len(mesh.faces), len(CLASSES)), int)
for _ in range(8):
    said = np.where(rng.random(len(truth)) < 0.6, truth, rng.integers(0, 4, len(truth)))
    sees = rng.random(len(truth)) < 2 / 3
    votes[np.flatnonzero(sees), said[sees]] += 1

result = meshseg.segment(mesh, probabilities=votes, classes=CLASSES)
print(result)
before, after = votes.argmax(axis=1) == truth, result.face_labels == truth
print(f"right: {before.mean():.1%} of the votes' maxima, {after.mean():.1%} of the labels")
assert after.mean() > 0.99
