"""Small meshes, and what most tests compute of them."""

from __future__ import annotations

import numpy as np
import pytest
from brute_force import BruteForce

import clsdf


def pytest_configure(config):
    # Small fields have thin bands.
    config.addinivalue_line("filterwarnings", "ignore:the band is .* voxels wide")


@pytest.fixture(scope="session")
def solid():
    """A closed mesh without symmetry, of different extents along x, y and z: vertices and faces."""
    vertices, faces = clsdf.make_shape("sphere1")
    random = np.random.default_rng(7)
    vertices = vertices * (1.0, 0.7, 0.5) * random.uniform(0.8, 1.2, (len(vertices), 1)) + (0.3, -0.2, 0.1)
    return vertices, faces


@pytest.fixture(scope="session")
def brute(solid):
    return BruteForce(*solid)


@pytest.fixture(scope="session")
def body(solid):
    return clsdf.Transform(solid)


@pytest.fixture(scope="session")
def points():
    return np.random.default_rng(3).uniform(-1.3, 1.3, (500, 3))
