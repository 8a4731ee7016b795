"""Crossings of a sphere for cut cells: at the sphere within the mesh's deviation, and of the level set's sides."""

from __future__ import annotations

import numpy as np
import pytest

import clsdf

SPACING = 0.07


@pytest.fixture(scope="module")
def ball():
    return clsdf.make_shape("sphere5")


@pytest.fixture(scope="module", params=["nodes", "cell centres"])
def grid(request):
    # The middle of the sphere, and so many ties, are nodes.
    nodes = clsdf.Grid((-18 * SPACING, -17 * SPACING, -19 * SPACING), SPACING, (37, 35, 39))
    return nodes if request.param == "nodes" else nodes.cell_centred()


def axes_of(grid):
    """x, y, z of the samples, each with an axis of length 1 for the others."""
    return [np.reshape(grid.origin[axis] + SPACING * np.arange(grid.size[axis]),
                       [-1 if a == 2 - axis else 1 for a in range(3)]) for axis in range(3)]


def test_crossings_lie_on_the_sphere_within_the_deviation_of_the_mesh(ball, grid):
    vertices, faces = ball
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    normals = np.cross(b - a, c - a)
    inner = np.min(np.einsum("ij,ij->i", a, normals) / np.linalg.norm(normals, axis=1))  # of the planes of the faces
    assert 0.999 < inner < 1
    edges = clsdf.Transform(ball).crossings(grid)
    positions = axes_of(grid)
    compared = 0
    for axis, crossings in enumerate((edges.x, edges.y, edges.z)):
        found = crossings.coordinates
        along = 2 - axis  # of the arrays
        others = [p for k, p in enumerate(positions) if k != axis]
        squared = others[0] ** 2 + others[1] ** 2
        crossed = np.isfinite(found)
        radius = np.sqrt(found**2 + squared)[crossed]
        assert radius.min() >= inner - 1e-12 and radius.max() <= 1 + 1e-12
        # The exact sphere's, where it crosses the same edge and is not nearly parallel to it.
        steep = crossed & (np.broadcast_to(squared, found.shape) < 0.75)
        exact = np.copysign(np.sqrt(1 - np.broadcast_to(squared, found.shape)[steep]), found[steep])
        assert abs(found[steep] - exact).max() <= 2.001 * (1 - inner)
        low = np.take(positions[axis], range(found.shape[along]), along)
        within = np.broadcast_to(low, found.shape)[crossed]
        assert ((found[crossed] >= within - 1e-12) & (found[crossed] <= within + SPACING + 1e-12)).all()
        compared += steep.sum()
    assert compared > 2500


def test_an_edge_is_crossed_an_odd_number_of_times_if_and_only_if_the_signs_differ(ball, grid):
    body = clsdf.Transform(ball)
    edges = body.crossings(grid, counts=True)
    distance = body.field(grid, band="full").distance
    clear = abs(distance) > 1e-6 * SPACING
    assert np.array_equal((distance < 0)[clear], edges.inside[clear]) and clear.mean() > 0.99
    for along, crossings in zip((2, 1, 0), (edges.x, edges.y, edges.z)):
        differ = np.diff(edges.inside.astype(np.int8), axis=along) != 0
        assert np.array_equal(np.isfinite(crossings.coordinates), differ)
        assert np.array_equal(crossings.counts % 2 == 1, differ) and differ.sum() > 1000
        assert np.array_equal(crossings.triangles != clsdf.no_triangle, differ)
