"""clsdf.trimesh takes the place of trimesh.proximity."""

from __future__ import annotations

import gc

import numpy as np
import pytest
from brute_force import BruteForce

import clsdf
import clsdf.trimesh

trimesh = pytest.importorskip("trimesh")


@pytest.fixture
def mesh(solid):
    return trimesh.Trimesh(*solid, process=False)


def test_the_sign_is_positive_inside(mesh, brute, points):
    distance = clsdf.trimesh.signed_distance(mesh, points.tolist())
    assert distance.dtype == np.float64 and distance.shape == (len(points),)
    assert np.allclose(distance, -brute.distance(points), atol=1e-12)
    assert clsdf.trimesh.signed_distance(mesh, [[0.3, -0.2, 0.1]])[0] > 0


def test_a_vertex_is_at_plus_zero(mesh):
    distance = clsdf.trimesh.signed_distance(mesh, mesh.vertices)
    assert not distance.any() and not np.signbit(distance).any()


def test_the_closest_point_its_distance_and_triangle(mesh, brute, points):
    closest, distance, triangle = clsdf.trimesh.closest_point(mesh, points)
    assert (closest.dtype, distance.dtype, triangle.dtype) == (np.float64, np.float64, np.int64)
    candidates = brute.closest(points)
    far = np.linalg.norm(candidates - points[:, None], axis=-1)
    assert np.allclose(distance, far.min(1), atol=1e-12)
    assert np.allclose(closest, candidates[np.arange(len(points)), triangle], atol=1e-12)


def test_the_results_are_those_of_trimesh(mesh, points):
    pytest.importorskip("rtree")
    pytest.importorskip("scipy")
    theirs = trimesh.proximity.signed_distance(mesh, points)
    assert np.allclose(clsdf.trimesh.signed_distance(mesh, points), theirs, atol=1e-8)
    closest, distance, _ = clsdf.trimesh.closest_point(mesh, points)
    their_closest, their_distance, _ = trimesh.proximity.closest_point(mesh, points)
    assert np.allclose(distance, their_distance, atol=1e-8) and np.allclose(closest, their_closest, atol=1e-6)


def test_a_mesh_that_changes_is_prepared_again(mesh, points):
    clsdf.trimesh.signed_distance(mesh, points)
    mesh.apply_scale(0.5)
    expected = -BruteForce(mesh.vertices, mesh.faces).distance(points)
    assert np.allclose(clsdf.trimesh.signed_distance(mesh, points), expected, atol=1e-12)


def test_a_mesh_is_prepared_once_and_forgotten_at_its_end(mesh, points, monkeypatch):
    made = []
    transform = clsdf.trimesh.Transform
    monkeypatch.setattr(clsdf.trimesh, "Transform", lambda *a, **k: made.append(1) or transform(*a, **k))
    for _ in range(3):
        clsdf.trimesh.signed_distance(mesh, points)
    assert len(made) == 1
    monkeypatch.undo()
    copy = mesh.copy()
    clsdf.trimesh.closest_point(copy, points)
    key = id(copy)
    assert {id(mesh), key} <= clsdf.trimesh._prepared.keys()
    del copy
    gc.collect()
    assert key not in clsdf.trimesh._prepared


def test_an_open_mesh_has_no_inside(mesh, points):
    half = trimesh.Trimesh(mesh.vertices, mesh.faces[:-5], process=False)
    with pytest.raises(clsdf.Error, match="edge") as error:
        clsdf.trimesh.signed_distance(half, points)
    assert error.value.code == "invalid_mesh"
    _, distance, _ = clsdf.trimesh.closest_point(half, points)
    expected = np.linalg.norm(BruteForce(half.vertices, half.faces).closest(points) - points[:, None], axis=-1).min(1)
    assert np.allclose(distance, expected, atol=1e-12)


def test_a_proximity_query_has_the_same_results(mesh, points):
    near = clsdf.trimesh.ProximityQuery(mesh)
    assert np.array_equal(near.signed_distance(points), clsdf.trimesh.signed_distance(mesh, points))
    for ours, function in zip(near.on_surface(points), clsdf.trimesh.closest_point(mesh, points)):
        assert np.array_equal(ours, function)


@pytest.mark.parametrize("call", [clsdf.trimesh.signed_distance, clsdf.trimesh.closest_point])
def test_what_is_no_mesh_of_trimesh_and_points_of_another_shape_are_refused(mesh, points, call):
    with pytest.raises(clsdf.Error, match=r"shape \(3,\); expected \(n, 3\)"):
        call(mesh, [0, 0, 0])
    with pytest.raises(clsdf.Error, match="tuple, not a trimesh.Trimesh"):
        call((mesh.vertices, mesh.faces), points)
