"""What several tests need."""

import numpy as np
import pytest

import meshseg


@pytest.fixture(scope="session")
def torus():
    return meshseg.read_mesh("torus:40x25")


@pytest.fixture(scope="session")
def costs(torus):
    return np.random.default_rng(1).random((len(torus.vertices), 3))
