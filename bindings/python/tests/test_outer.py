"""The outer surface of parts that overlap, and the parts of cells that they fill."""

import copy
import warnings

import numpy as np
import pytest

import clsdf

CUBE = np.array([[x, y, z] for z in (-1, 1) for y in (-1, 1) for x in (-1, 1)], float)
SIDES = np.array([[0, 2, 3], [0, 3, 1], [4, 5, 7], [4, 7, 6], [0, 1, 5], [0, 5, 4], [2, 6, 7], [2, 7, 3], [0, 4, 6],
                  [0, 6, 2], [1, 3, 7], [1, 7, 5]])


def bar():
    """Two cubes of side 2: a bar of 3 by 2 by 2."""
    groups = (["left", "right"], np.repeat([0, 1], 12))
    return clsdf.Mesh(np.concatenate([CUBE, CUBE + (1, 0, 0)]), np.concatenate([SIDES, SIDES + 8]), groups, "bar")


def test_the_outer_surface_of_two_cubes():
    mesh = bar()
    surface = clsdf.outer(mesh)
    assert surface.volume == 12 and surface.area == 32
    assert surface.whole_faces + surface.partial_faces + surface.hidden_faces == 24 and surface.hidden_faces >= 4
    assert surface.faces.shape == (len(surface.mesh.faces),) and surface.faces.dtype == np.uint32
    assert surface.mesh.name == "bar" and surface.mesh.groups.names == ["left", "right"]
    assert np.array_equal(surface.mesh.groups.numbers, surface.faces // 12)
    with pytest.warns(clsdf.MeshWarning, match="outer"):
        given = clsdf.Transform(mesh)
    union = clsdf.Transform(surface.mesh)
    points = [[0.5, 0, 0], [0.5, 0.5, 0.5], [-0.5, 0, 0]]
    assert np.allclose(union.query(points).distance, [-1, -0.5, -0.5])
    assert np.allclose(given.query(points).distance, [-0.5, -0.5, -0.5])
    assert len(clsdf.outer((mesh.vertices, mesh.faces[:12])).faces) == 12
    with pytest.raises(clsdf.Error, match="closed mesh") as error:
        clsdf.outer((mesh.vertices, mesh.faces[:11]))
    assert error.value.code == "unsupported"
    with pytest.raises(clsdf.Error, match="sign"):
        clsdf.outer(mesh, sign="below")


def test_a_sample_of_a_transform_is_near_its_surface():
    with pytest.warns(clsdf.MeshWarning, match="not on the outer surface"):
        body = clsdf.Transform(bar(), surface="outer")
    points = body.sample(500, within=0.05, seed=3)
    assert np.abs(body.query(points, dtype="float64").distance).max() < 0.05 + 1e-12


def test_an_outer_surface_warns_of_parts_that_look_inwards():
    mesh = bar()
    faces = mesh.faces.copy()
    faces[12:] = faces[12:, ::-1]
    with pytest.warns(clsdf.MeshWarning, match="1 of 2 parts looks inwards"):
        assert clsdf.outer((mesh.vertices, faces)).volume == 8  # without the overlap, which is outside


def test_a_transform_of_the_outer_surface():
    mesh = bar()
    surface = clsdf.outer(mesh)
    with pytest.warns(clsdf.MeshWarning, match="not on the outer surface"):
        body = clsdf.Transform(mesh, surface="outer")
    assert body.topology.hidden_faces == surface.hidden_faces and body.topology.partial_faces == surface.partial_faces
    points = np.random.default_rng(4).uniform(-1.5, 2.5, (200, 3))
    outputs = "triangle site barycentric closest"
    found = body.query(points, outputs)
    plain = clsdf.Transform(surface.mesh).query(points, outputs)
    assert np.array_equal(found.distance, plain.distance)
    assert np.array_equal(found.triangle, surface.faces[plain.triangle])
    corners = mesh.vertices[mesh.faces[found.triangle]]
    weights = np.concatenate([1 - found.barycentric.sum(-1, keepdims=True), found.barycentric], -1)
    assert np.allclose((weights[..., None] * corners).sum(1), found.closest, atol=1e-6)
    assert found.site.max() <= 7 and (found.site == 6).sum() > 50
    with warnings.catch_warnings():
        warnings.simplefilter("error")  # what was said is not said again
        again = copy.copy(body)
    assert np.array_equal(again.query(points).distance, found.distance)
    body.set_positions(mesh.vertices + np.where(np.arange(16) < 8, 0, 1)[:, None] * (1, 0, 0))
    assert np.allclose(body.query([[1, 0, 0], [-0.5, 0, 0]]).distance, [-1, -0.5])
    with pytest.raises(clsdf.Error, match="surface"):
        clsdf.Transform(mesh, surface="inner")


def test_fractions_of_two_cubes():
    grid = clsdf.Grid((-1.25, -1.25, -1.25), (0.5, 0.5, 0.5), (8, 6, 6))
    found = clsdf.fractions(bar(), grid)
    dense = found.dense()
    assert dense.shape == (5, 5, 7) and found.full.shape == (5, 5, 7) and found.full.dtype == np.bool_
    assert np.isclose(dense.sum() * 0.125, 12) and np.isclose(found.area.sum(), 32)
    along = np.array([0.5, 1, 1, 1, 1, 1, 0.5])
    across = np.array([0.5, 1, 1, 1, 0.5])
    assert np.allclose(dense, across[:, None, None] * across[:, None] * along)
    corner = found.cells.tolist().index([0, 0, 0])
    assert np.allclose(found.centroid[corner], 0.25) and np.allclose(found.face_fractions[corner], [0, 0.25] * 3)
    assert found.pieces[corner] == 1 and np.allclose(found.vector_area[corner], -0.0625)
    assert np.allclose(found.face_centroids[corner][1::2], 0.25)
    assert found.face_centroids.shape == (len(found.cells), 6, 2) and found.surface_centroid.shape == (len(found.cells), 3)
    with pytest.raises(clsdf.InvalidArgument, match="two samples"):
        clsdf.fractions(bar(), clsdf.Grid((0, 0, 0), (1, 1, 1), (3, 3, 1)))


def test_fractions_of_many_boxes_of_one_outer_surface():
    grid = clsdf.Grid((-1.25, -1.25, -1.25), (0.5, 0.5, 0.5), (8, 6, 6))
    surface = clsdf.outer(bar())
    boxes = [grid.part((0, 0, 0), (5, 6, 6)), grid.part((4, 0, 0), (4, 6, 6)), grid.refined(2)]
    left, right, fine = clsdf.fractions(surface, boxes)
    whole = clsdf.fractions(bar(), grid)
    assert np.array_equal(np.concatenate([left.dense(), right.dense()], 2), whole.dense())
    of_eight = fine.dense().reshape(5, 2, 5, 2, 7, 2).mean((1, 3, 5))
    assert np.allclose(of_eight, whole.dense(), atol=1e-13)
    assert np.allclose(fine.dense("area").reshape(5, 2, 5, 2, 7, 2).sum((1, 3, 5)), whole.dense("area"))
    across_x, across_y, across_z = whole.dense_faces()
    assert across_x.shape == (5, 5, 8) and across_y.shape == (5, 6, 7) and across_z.shape == (6, 5, 7)
    assert np.allclose(np.diff(across_x, axis=2), -whole.dense("vector_area")[..., 0] / 0.25)
    assert np.allclose(np.diff(across_z, axis=0), -whole.dense("vector_area")[..., 2] / 0.25)
    with pytest.raises(ValueError, match="'grid' is no column"):
        whole.dense("grid")


def test_conventions_of_fractions():
    cube = (CUBE, SIDES)
    grid = clsdf.Grid((-3, -3, -3), (2, 2, 2), (4, 4, 4))  # the walls lie between cells
    plain = clsdf.fractions(cube, grid)
    amrex = clsdf.fractions(cube, grid, convention="amrex")
    # The three low walls in the cube's own cell; each of six in a cell of the fluid.
    assert plain.area[plain.cells.tolist().index([1, 1, 1])] == 12
    assert len(amrex.cells) == 6 and not amrex.full[1, 1, 1] and amrex.full[0, 0, 0]
    assert (amrex.volume == 1).all() and (amrex.area == 1).all()
    assert np.array_equal(amrex.vector_area, [1, 1, 1] - amrex.cells)
    assert len(clsdf.fractions(cube, grid, walls="solid").cells) == 1
    solid = clsdf.fractions(cube, grid, convention="amrex", part="solid")
    # A flow within the mesh: its own cell has all six walls.
    assert solid.cells.tolist() == [[1, 1, 1]] and solid.volume[0] == 1 and (solid.face_fractions == 0).all()
    points = clsdf.fractions(cube, clsdf.Grid((-3.5, -3.5, -3.5), (2, 2, 2), (4, 4, 4)), convention="vtk")
    assert np.allclose(points.centroid[points.volume > 0].min(0), (-0.25, -0.25, -0.25))
    thirds = clsdf.Grid((0, 0, 0), (0.1, 0.1, 0.1), (6, 6, 6))
    small = (0.2 + 0.1 * CUBE, SIDES)  # from 0.1 to 0.30000000000000004
    assert len(clsdf.fractions(small, thirds, walls="solid", snap=1e-9).cells) == 8
    for wrong in ({"convention": "amrx"}, {"part": "air"}, {"walls": "below"}, {"snap": 1}):
        with pytest.raises(clsdf.InvalidArgument, match=next(iter(wrong.values())) if wrong.get("snap") is None else "snap"):
            clsdf.fractions(cube, grid, **wrong)
