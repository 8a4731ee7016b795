"""Links and crossings are those of a box whose walls are known, and files are those that NumPy reads."""

from __future__ import annotations

import numpy as np
import pytest

import clsdf


@pytest.fixture(scope="module")
def box():
    """From 1.25 to 5.25 on each axis."""
    vertices = np.array([[x, y, z] for z in (1.25, 5.25) for y in (1.25, 5.25) for x in (1.25, 5.25)])
    faces = [(0, 3, 1), (0, 2, 3), (4, 5, 7), (4, 7, 6), (0, 1, 5), (0, 5, 4), (2, 7, 3), (2, 6, 7), (0, 6, 2), (0, 4, 6),
             (1, 3, 7), (1, 7, 5)]  # fmt: skip
    return clsdf.Transform(vertices, np.array(faces))


GRID = clsdf.Grid((0, 0, 0), (1, 1, 1), (8, 8, 8))


def test_links_are_where_sides_differ(box):
    links = box.links(GRID, ("D3Q19", "OpenLB"))
    inside = np.zeros((8, 8, 8), bool)
    inside[2:6, 2:6, 2:6] = True
    assert np.array_equal(links.inside, inside)
    expected = 0
    for x, y, z in links.stencil[1:]:
        other = np.roll(inside, (-z, -y, -x), (0, 1, 2))
        expected += (~inside & other).sum()
    assert len(links) == expected == box.count_links(GRID, ("D3Q19", "OpenLB"))
    assert (links.counts == 1).all() and (links.flags == 0).all()
    along = links.directions == 10
    assert (links.stencil[10] == (1, 0, 0)).all() and along.sum() == 16
    assert (links.samples[along, 0] == 1).all() and (links.q[along] == 0.25).all()
    assert set(links.triangles[along]) == {8, 9}
    dense = links.dense()
    assert dense.shape == (19, 8, 8, 8) and dense[10, 3, 3, 1] == 0.25 and (dense[0] == -1).all()
    assert box.links(GRID, [(1, 0, 0)], dtype=np.float32).q.dtype == np.float32
    # As a float, a q that is not 1 stays below.
    near = clsdf.Grid((1.25 - 1 + 2.0**-30, 3, 3), (1, 1, 1), (1, 1, 1))
    for dtype in (np.float32, np.float64):
        assert 0.999 < box.links(near, [(1, 0, 0)], dtype=dtype).q[0] < 1


def test_slabs_have_the_rows_of_the_whole(box):
    grid = clsdf.Grid((0, 0, 0), (0.008, 0.008, 0.05), (800, 800, 120))
    whole = box.links(grid, [(0, 0, 1), (1, -1, 0)])
    parts = list(box.link_slabs(grid, [(0, 0, 1), (1, -1, 0)]))
    assert len(parts) > 1 and len(whole) > 10000
    for name in ("samples", "directions", "q", "triangles", "counts", "flags", "inside"):
        assert np.array_equal(np.concatenate([getattr(part, name) for part in parts]), getattr(whole, name))
    assert sum(part.grid.shape[0] for part in parts) == 120


def test_crossings_are_coordinates(box):
    edges = box.crossings(GRID, counts=True)
    assert edges.x.coordinates.shape == (8, 8, 7) and edges.z.coordinates.shape == (7, 8, 8)
    assert edges.x.coordinates[3, 3, 1] == 1.25 and edges.x.coordinates[3, 3, 5] == 5.25
    assert np.isfinite(edges.x.coordinates).sum() == edges.x.counts.sum() == 32
    assert (edges.x.triangles == clsdf.no_triangle).sum() == edges.x.triangles.size - 32
    assert box.crossings(GRID).y.counts is None
    flat = box.crossings(clsdf.Grid(GRID.origin, GRID.spacing, (9, 9, 1)), counts=True)
    assert flat.z.coordinates.shape == flat.z.counts.shape == (0, 9, 9) and flat.x.coordinates.shape == (1, 9, 8)


def test_errors_name_what_is_wrong(box):
    for directions, words in [("D3Q20", "D3Q20"), ([(1, 0, 0), (0, 1)], "three whole"), ([(17, 0, 0)], "16"), ([(0.5, 0, 0)], "whole"), ([(1, 0)], "shape")]:
        with pytest.raises(clsdf.Error, match=words):
            box.links(GRID, directions)
    with pytest.raises(clsdf.Error, match="walls"):
        box.links(GRID, hits="corners")
    for call in (box.links, box.crossings, box.count_links):
        with pytest.raises(clsdf.Error, match="grid: 8 is no clsdf.Grid"):
            call(8)
    with pytest.raises(clsdf.Error, match="limit: .* lengths of the direction"):
        box.rays([(0, 0, 0)], [(1, 0, 0)], limit=np.array([1, 2]))
