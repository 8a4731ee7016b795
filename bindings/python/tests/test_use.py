"""What people who train, move and look at things do: shapes, frames, poses, travel between processes, notebooks."""

from __future__ import annotations

import copy
import inspect
import math
import pickle
import subprocess
import sys
import textwrap
import types
import warnings

import numpy as np
import pytest
from test_arrays import OnlyDLPack

import clsdf

ALL = "distance triangle site closest gradient barycentric offset"


def turned(angle, axis):
    """The rotation about an axis, in double."""
    x, y, z = np.asarray(axis, float) / np.linalg.norm(axis)
    k = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + math.sin(angle) * k + (1 - math.cos(angle)) * k @ k


def test_points_of_more_axes_and_none(body, points):
    flat = body.query(points, ALL)
    deep = body.query(points.reshape(5, 4, 25, 3), ALL)
    for name, array in deep.arrays.items():
        assert array.shape[:3] == (5, 4, 25) and np.array_equal(array.reshape(flat[name].shape), flat[name], equal_nan=True), name
    assert len(deep) == len(flat) == 500 and len(body.query((0, 0, 0))) == 1
    out = {"distance": np.empty((5, 100)), "gradient": np.empty((5, 100, 3), np.float32)}
    result = body.query(points.reshape(5, 100, 3), out=out)
    assert result.distance is out["distance"] and np.array_equal(out["gradient"].reshape(-1, 3), flat.gradient)
    with pytest.raises(clsdf.Error, match=r"shape \(100, 5\); expected \(5, 100\)"):
        body.query(points.reshape(5, 100, 3), out=np.empty((100, 5)))
    with pytest.raises(clsdf.Error, match="strides"):
        body.query(points.reshape(5, 100, 3), out=np.empty((100, 5)).T)
    for other in (memoryview(points.reshape(5, 100, 3)), OnlyDLPack(points.reshape(5, 100, 3))):
        assert np.array_equal(body.query(other).distance, result.distance.astype(np.float32))
        assert np.array_equal(body.query(other, frame=np.eye(4)).distance, body.query(other).distance)
    for none, shape in (([], (0,)), (np.empty((4, 0, 3)), (4, 0)), (np.empty((0, 3)), (0,))):
        found = body.query(none, "closest")
        assert found.distance.shape == shape and found.closest.shape == (*shape, 3) and len(found) == 0
        assert body.contains(none).shape == shape


def test_dtype_is_that_of_real_outputs(body, points):
    expected = np.empty(len(points))
    body.query(points, out=expected)
    found = body.query(points, "gradient closest triangle", dtype="float64")
    assert np.array_equal(found.distance, expected) and found.gradient.dtype == np.float64
    assert (found.closest.dtype, found.triangle.dtype) == (np.float64, np.uint32)
    grid = body.grid(12)
    field = body.field(grid, outputs="gradient", dtype=np.float64)
    out = {"distance": np.empty(grid.shape), "gradient": np.empty((*grid.shape, 3))}
    body.field(grid, out=out)
    assert np.array_equal(field.distance, out["distance"]) and np.array_equal(field.gradient, out["gradient"], equal_nan=True)
    for wrong in ("int32", "what"):
        with pytest.raises(clsdf.Error, match="neither 'float32' nor 'float64'"):
            body.query(points, dtype=wrong)
    with pytest.raises(clsdf.Error, match="exclude each other"):
        body.query(points, dtype="float64", out=expected)


def test_contains_is_the_exact_sign(solid, body, brute, points):
    inside = body.contains(points.reshape(10, 50, 3))
    assert inside.dtype == bool and np.array_equal(inside.ravel(), brute.distance(points) < 0) and inside.any()
    assert not body.contains(solid[0]).any()  # on the surface
    assert body.contains((0.3, -0.2, 0.1)) and body.contains((0.3, -0.2, 0.1)).shape == ()
    with pytest.warns(clsdf.MeshWarning) as warned:
        assert not body.contains([[np.nan, 0, 0]]).any()
    assert warned[0].filename == __file__
    with pytest.raises(clsdf.InvalidMesh, match="no inside"):
        clsdf.Transform(solid, sign="none").contains(points)


def test_vertices_and_faces_are_the_present_ones(solid, tmp_path):
    vertices, faces = solid[0].copy(), solid[1].copy()
    body = clsdf.Transform(vertices, faces)
    vertices[:] = 7
    assert np.array_equal(body.vertices, solid[0]) and np.array_equal(body.faces, solid[1])
    with pytest.raises(ValueError, match="read-only"):
        body.vertices[0, 0] = 1
    body.set_positions(solid[0] * 2)
    assert np.array_equal(body.vertices, solid[0] * 2)
    body.set_motion(turned(0.7, (1, 2, 3)), (0.5, 0, 0))
    assert np.allclose(body.vertices, solid[0] @ turned(0.7, (1, 2, 3)).T + (0.5, 0, 0), atol=1e-14)
    again = clsdf.Transform(body.vertices, body.faces)
    assert np.array_equal(again.box, body.box)


def test_positions_of_a_grid_are_those_of_its_samples():
    grid = clsdf.Grid((0.1, -0.2, 0.3), (0.1, 0.3, 0.7), (4, 3, 2), first=(5, -6, 7))
    positions = grid.positions()
    assert positions.shape == (2, 3, 4, 3) and positions.dtype == np.float64
    for k, j, i in np.ndindex(2, 3, 4):
        assert tuple(positions[k, j, i]) == grid.position(i, j, k)


@pytest.mark.parametrize("points_type", [np.float64, np.float32])
def test_a_frame_is_the_motion_of_the_body(solid, points, points_type):
    still, moving = clsdf.Transform(solid), clsdf.Transform(solid)
    rotation, translation = turned(2.1, (3, -1, 2)), np.array((0.3, 0.2, -0.4))
    points = points.astype(points_type)
    pose = np.eye(4)
    pose[:3, :3], pose[:3, 3] = rotation, translation
    moving.set_motion(pose)
    expected = moving.query(points, ALL, dtype="float64")
    for frame in ((rotation, translation), pose):
        found = still.query(points, ALL, frame=frame, dtype="float64")
        for name in ("distance", "closest", "gradient", "offset"):
            assert np.allclose(found[name], expected[name], atol=1e-10), name
        assert np.array_equal(found.triangle, expected.triangle)
        assert np.array_equal(still.contains(points, frame=frame), moving.contains(points))
    one = still.query(points[0], "closest", frame=pose)
    assert one.closest.shape == (3,) and np.allclose(one.closest, expected.closest[0])
    assert np.array_equal(still.box, [solid[0].min(0), solid[0].max(0)])


def test_a_rotation_in_floats_is_made_one(solid, points):
    body = clsdf.Transform(solid)
    exact = turned(0.7, (1, 2, 3))
    rotation, translation = body.set_motion(exact, (0.5, 0, 0))
    assert np.array_equal(rotation, exact) and translation.tolist() == [0.5, 0, 0]
    single = exact.astype(np.float32)
    assert abs(single.astype(float) @ single.T.astype(float) - np.eye(3)).max() > 1e-9
    for given in (single, single.astype(float)):
        rotation, _ = body.set_motion(given, np.float32([0.5, 0, 0]))
        assert abs(rotation @ rotation.T - np.eye(3)).max() < 1e-15 * 4 and abs(rotation - exact).max() < 1e-7
        assert abs(rotation - polar(given)).max() < 1e-15
        assert rotation.tobytes().hex() == body.set_motion(single, (0, 0, 0))[0].tobytes().hex()


def test_rotations_of_scipy_are_frames(solid, points):
    transforms = pytest.importorskip("scipy.spatial.transform")
    body = clsdf.Transform(solid)
    turn, shift = transforms.Rotation.from_rotvec([0.3, -0.2, 0.5]), (0.1, 0.2, -0.3)
    pose = np.eye(4)
    pose[:3, :3], pose[:3, 3] = turn.as_matrix(), shift
    expected = body.query(points, frame=pose).distance
    motions = [(turn, shift)]
    if hasattr(transforms, "RigidTransform"):
        motions.append(transforms.RigidTransform.from_components(shift, turn))
    for motion in motions:
        assert np.array_equal(body.query(points, frame=motion).distance, expected)
        assert np.array_equal(body.contains(points, frame=motion), expected < 0)
    assert np.array_equal(body.query(points, frame=turn).distance, body.query(points, frame=(turn, (0, 0, 0))).distance)
    body.set_motion(turn, shift)
    assert np.allclose(body.query(points).distance, expected, atol=1e-6)
    body.set_motion(turn)
    assert np.allclose(body.vertices, solid[0] @ turn.as_matrix().T)
    with pytest.raises(clsdf.Error, match=r"shape \(2, 3, 3\)"):
        body.query(points, frame=(transforms.Rotation.from_rotvec(np.zeros((2, 3))), (0, 0, 0)))


def test_whole_numbers_are_points(body):
    corners = np.array([[0, 0, 0], [1, -1, 2]])
    expected = body.query(corners.astype(float)).distance
    for points in (corners, corners.astype(np.int32), corners.astype(np.int16),
                   corners.tolist(), OnlyDLPack(corners)):
        assert np.array_equal(body.query(points).distance, expected)
        assert np.array_equal(body.contains(points), expected < 0)
    assert np.array_equal(body.winding(corners), body.winding(corners.astype(float)))
    assert np.array_equal(body.rays(corners, corners[::-1] + 1).t, body.rays(corners + 0.0, corners[::-1] + 1.0).t, equal_nan=True)


def test_each_point_may_have_its_limit(body, points):
    random = np.random.default_rng(5)
    many = random.uniform(-1.5, 1.5, (3000, 3))
    limits = np.exp(random.uniform(-6, 1, 3000))
    limits[::50], limits[1::50] = np.inf, 0
    many[2] = body.vertices[0]
    for dtype in ("float32", "float64"):
        found = body.query(many, ALL, within=limits, dtype=dtype)
        free = body.query(many, ALL, dtype=dtype)
        # As if each point had a call of its own.
        for n in (*range(0, 3000, 37), 0, 1, 2, 50):
            one = body.query(many[n], ALL, within=limits[n], dtype=dtype)
            for name in one.outputs:
                assert np.array_equal(one[name], found[name][n], equal_nan=name != "triangle"), (name, n)
        is_near = abs(body.query(many, dtype="float64").distance) <= limits
        assert 0.1 < is_near.mean() < 0.9
        for name in found.outputs:
            assert np.array_equal(found[name][is_near], free[name][is_near], equal_nan=True)
        assert (found.triangle[~is_near] == clsdf.no_triangle).all()
    out = {"distance": np.empty(3000), "triangle": np.empty(3000, np.int32)}
    body.query(many, within=limits, out=out)
    assert np.array_equal(out["distance"], found.distance) and (out["triangle"][~is_near] == -1).all()
    deep = body.query(many.reshape(3, 1000, 3), within=limits.reshape(3, 1000), dtype="float64")
    assert np.array_equal(deep.distance.ravel(), found.distance)
    many[7] = np.nan
    with pytest.warns(clsdf.MeshWarning) as warned:
        found = body.query(many, within=limits)
    assert len(warned) == 1 and np.isnan(found.distance[7])  # as with a limit for all
    lost = [[np.nan, 0, 0], [1e30, 0, 0]]
    for within, of_the_far_one in ((0.5, 0.5), ([0.5, 0.5], 0.5), ([np.inf, 0.5], 0.5), ([0.5, np.inf], np.nan)):
        with pytest.warns(clsdf.MeshWarning):
            found = body.query(lost, within=within, dtype="float64").distance
        assert np.array_equal(found, [np.nan, of_the_far_one], equal_nan=True)
    with pytest.raises(clsdf.Error, match=r"\b7\b"):
        body.query(many, within=limits, refuse_unusable_points=True)
    for wrong, message in ((limits[:5], r"shape \(5,\); expected a number, or \(3000,\)"), (-limits, "below 0 or NaN"),
                           (["a"] * 3000, "neither a number")):
        with pytest.raises(clsdf.Error, match=message):
            body.query(many, within=wrong)


def test_volume_area_and_bounds_are_those_of_the_faces(solid):
    vertices, faces = clsdf.make_shape("cube")
    side = np.ptp(vertices[:, 0])
    body = clsdf.Transform(vertices + 1000, faces)
    assert body.volume == pytest.approx(side**3, rel=1e-12) and body.area == pytest.approx(6 * side**2, rel=1e-12)
    assert np.array_equal(body.bounds, body.box)
    with pytest.warns(clsdf.MeshWarning, match="within others"):
        both = clsdf.Transform(np.concatenate([vertices, vertices + 0.1]), np.concatenate([faces, faces + len(vertices)]))
    assert both.volume == pytest.approx(2 * side**3)
    body.set_positions(vertices * 2)
    assert body.volume == pytest.approx(8 * side**3)
    trimesh = pytest.importorskip("trimesh")
    mesh, body = trimesh.Trimesh(*solid, process=False), clsdf.Transform(solid)
    assert body.volume == pytest.approx(mesh.volume) and body.area == pytest.approx(mesh.area)


@pytest.mark.filterwarnings("ignore::clsdf.MeshWarning")
def test_volume_is_what_the_sign_says_is_inside():
    vertices, faces = clsdf.make_shape("sphere3")
    whole = clsdf.Transform(vertices, faces).volume
    turned = faces.copy()
    turned[::7] = turned[::7, ::-1]
    for first in (0, 100, 501):
        assert clsdf.Transform(vertices, np.roll(turned, first, 0)).volume == pytest.approx(whole)
    nested = np.concatenate([vertices, vertices / 2]), np.concatenate([faces, faces + len(vertices)])
    assert clsdf.Transform(nested).volume == pytest.approx(whole * 9 / 8)
    assert clsdf.Transform(nested, sign="parity").volume == pytest.approx(whole * 7 / 8)
    assert clsdf.Transform(nested, surface="outer").volume == pytest.approx(whole)
    with pytest.raises(clsdf.Error, match="solid-angle, and an open surface encloses no volume"):
        clsdf.Transform(vertices, faces[1:]).volume  # noqa: B018


def test_a_transform_with_a_sign_of_its_own_is_no_mesh():
    solid = clsdf.make_shape("cube")
    assert clsdf.outer(clsdf.Transform(solid)).volume == clsdf.outer(solid).volume
    scene, grid = clsdf.Scene(), clsdf.Transform(solid).grid(9)
    for body in (clsdf.Transform(solid, sign="parity"), clsdf.Transform(solid, surface="outer")):
        for take in (clsdf.outer, lambda mesh: clsdf.fractions(mesh, grid), scene.add, clsdf.Transform):
            with pytest.raises(clsdf.Error, match="its mesh alone, and this one has (sign='parity'|surface='outer')"):
                take(body)
    with pytest.raises(clsdf.Error, match=r"scene.outer\(\).surface.mesh"):
        clsdf.outer(scene)
    with pytest.raises(clsdf.Error, match="pass the mesh in it, surface.mesh"):
        clsdf.Transform(clsdf.outer(solid))


def polar(matrix):
    u, _, v = np.linalg.svd(np.asarray(matrix, float))
    return u @ v


@pytest.mark.parametrize(
    "motion, message",
    [
        ((2 * np.eye(3), (0, 0, 0)), "no rotation to 1e-5, but 3 off.*svd.*Rotation"),
        ((np.diag([1, 1, -1.0]), (0, 0, 0)), "a reflection.*exchange two vertices of each face"),
        ((np.full((3, 3), np.nan), (0, 0, 0)), "no rotation"),
        ((np.eye(3), (0, np.inf, 0)), "not finite"),
        ((np.eye(3),), r"shape \(3, 3\); expected \(4, 4\)"),
        ((np.ones((4, 4)),), r"last row .* not \[0, 0, 0, 1\]"),
    ],
)
def test_what_is_no_motion(body, points, motion, message):
    with pytest.raises(clsdf.Error, match=message):
        body.set_motion(*motion)
    with pytest.raises(clsdf.Error, match=message):
        body.query(points, frame=motion if len(motion) == 2 else motion[0])


def test_samples_lie_on_the_surface_or_near_it():
    body = clsdf.Transform(clsdf.make_shape("sphere3"))
    on = body.sample(4000, seed=5)
    assert np.array_equal(on, body.sample(4000, seed=5)) and not np.array_equal(on, body.sample(4000, seed=6))
    assert on.shape == (4000, 3) and abs(body.query(on, dtype="float64").distance).max() < 1e-12
    assert abs(on.mean(0)).max() < 0.05 and abs((on > 0).mean(0) - 0.5).max() < 0.05
    near = abs(body.query(body.sample(4000, 0.2, seed=5)).distance)
    assert near.max() <= 0.2 and 0.04 < near.mean() < 0.06
    body.set_positions(body.vertices + 10)
    assert body.sample(10, seed=1).min() > 8 and body.sample(0).shape == (0, 3)
    for n, within in ((-1, 0), (5, -0.1), (5, math.inf)):
        with pytest.raises(clsdf.Error, match="0 or more"):
            body.sample(n, within)


def test_plain_results_are_pickled(solid):
    body = clsdf.Transform(solid)
    with pytest.warns(clsdf.MeshWarning):
        open_body = clsdf.Transform(solid[0], solid[1][1:])
    defects = clsdf.find_defects((solid[0], np.concatenate([solid[1], solid[1][:2, ::-1]])))
    for thing in (body.topology, open_body.topology, defects, body.device.info(), clsdf.Band(1, 2), body.grid(9)):
        for other in (pickle.loads(pickle.dumps(thing)), copy.deepcopy(thing)):
            assert repr(other) == repr(thing)
            for name in dir(thing):
                if not name.startswith("_") and not callable(getattr(thing, name)):
                    assert getattr(other, name) == getattr(thing, name), name


def sheet_beside(faces):
    """A sphere, of which these faces are there, and a sheet that the sign leaves out."""
    vertices = np.concatenate([clsdf.make_shape("sphere3")[0], [(-3, -3, 1.6), (3, -3, 1.6), (3, 3, 1.6), (-3, 3, 1.6)]])
    count = len(vertices)
    return vertices, np.concatenate([faces, [(count - 4, count - 3, count - 2), (count - 4, count - 2, count - 1)]])


@pytest.mark.parametrize("has_hole", [False, True])
def test_copies_and_images_have_the_sign_that_was_decided(points, has_hole):
    vertices, faces = clsdf.make_shape("sphere3")
    if has_hole:
        faces = faces[vertices[faces].mean(1)[:, 2] < 0.93]
    with pytest.warns(clsdf.MeshWarning):
        body = clsdf.Transform(sheet_beside(faces))
    expected = body.query(points).distance
    assert (expected < 0).any()
    with warnings.catch_warnings():
        warnings.simplefilter("error")  # what was said is not said again
        for other in (copy.copy(body), pickle.loads(pickle.dumps(body))):
            assert np.array_equal(other.query(points).distance, expected) and other.sign == body.sign
        grid = clsdf.Grid((-1.5, -1.5, -1.5), 0.25, (13, 13, 13))
        image = types.SimpleNamespace(GetOrigin=lambda: (-1.5,) * 3, GetSpacing=lambda: (0.25,) * 3, GetSize=lambda: (13,) * 3,
                                      GetDirection=lambda: tuple(np.eye(3).ravel()), GetDimension=lambda: 3)
        assert np.array_equal(body.field(image=image, band="full").distance < 0, body.field(grid, band="full").distance < 0)


def test_a_part_knows_what_is_inside(points):
    body = clsdf.Transform(clsdf.make_shape("sphere3"))
    inside = points[(np.abs(points) < 0.5).all(1)]
    part = body.restrict_to(clsdf.Region((-0.5,) * 3, (0.5,) * 3, 0.2))
    for own in (part, pickle.loads(pickle.dumps(part))):
        assert np.array_equal(own.contains(inside), body.contains(inside))


def test_a_transform_is_pickled_where_it_is(solid, points):
    body = clsdf.Transform(solid, sign="nonzero", kept_bytes=1 << 20)
    inside = points[(np.abs(points) < 0.3).all(1)] + (0.3, 0, 0)
    part = body.restrict_to(clsdf.Region((-1, -1, -1), (1, 1, 1), 1.0))
    for move in (lambda: None, lambda: body.set_positions(solid[0] * 1.25), lambda: body.set_motion(turned(1, (1, 1, 0)), (0.1, 0, 0))):
        move()
        other = pickle.loads(pickle.dumps(body))
        assert np.array_equal(other.query(points).distance, body.query(points).distance)
        assert (other.sign, other.mesh_name, other.device.name) == (body.sign, body.mesh_name, body.device.name)
    again = pickle.loads(pickle.dumps(part))
    assert np.array_equal(again.query(inside, within=0.5).distance, part.query(inside, within=0.5).distance)
    with pytest.raises(clsdf.Error, match="region"):
        again.query([[5, 5, 5]], within=0.5)
    module = sys.modules["clsdf._devices"]
    with pytest.raises(clsdf.Error, match="'no such device', which this machine does not have; send the mesh") as error:
        module.device_again("no such device")
    assert error.value.code == "no_device"


def test_a_device_is_pickled_with_its_limits(solid, points):
    whole = clsdf.Device.automatic()
    again = pickle.loads(pickle.dumps(whole))
    assert again.name == whole.name and again.info().compute_units == whole.info().compute_units
    assert copy.copy(whole) is whole and copy.deepcopy(whole) is whole
    limits = {"memory": 1 << 28}
    if whole.info().kind == "processor" and whole.info().compute_units > 1:
        limits["compute_units"] = 1
    part = whole.limited(**limits)
    body = clsdf.Transform(solid, device=part)
    for device in (pickle.loads(pickle.dumps(part)), pickle.loads(pickle.dumps(body)).device):
        info = device.info()
        assert info.compute_units == part.info().compute_units == limits.get("compute_units", info.compute_units)
        assert info.memory == part.info().memory == 1 << 28
    assert pickle.loads(pickle.dumps((part, body)))[0].name == part.name
    other = pickle.loads(pickle.dumps(body))
    assert np.array_equal(other.query(points).distance, body.query(points).distance)
    # Transforms of one process share the device, and so its compiled programs.
    one, two = (pickle.loads(pickle.dumps(body)).device for _ in range(2))
    assert one.context_int_ptr == two.context_int_ptr


SENT = """
    import multiprocessing, sys
    import numpy as np
    import clsdf
    def work(job):
        body, point = job
        return float(body.query(point).distance), body.topology
    if __name__ == "__main__":
        body = clsdf.Transform(clsdf.make_shape("sphere1"))
        body.set_positions(body.vertices * 2)
        jobs = [(body, (0, 0, 0)), (body, (0, 0, 9))]
        expected = [work(job) for job in jobs]
        with multiprocessing.get_context("spawn").Pool(2) as pool:
            found = pool.map(work, jobs)
        print([a[0] == b[0] for a, b in zip(found, expected)], found[0][1].closed)
"""


def test_a_spawned_process_gets_a_transform_and_returns_results(tmp_path):
    (tmp_path / "sent.py").write_text(textwrap.dedent(SENT))
    result = subprocess.run([sys.executable, "sent.py"], capture_output=True, text=True, timeout=200, cwd=tmp_path)
    assert result.stdout.strip() == "[True, True] True", result.stderr


def test_results_by_name(body, points):
    found = body.query(points, "triangle")
    assert found["triangle"] is found.triangle
    with pytest.raises(KeyError, match="no 'gradient' here, but distance, triangle"):
        found["gradient"]
    with pytest.raises(TypeError, match="iterable"):
        iter(found)


def test_looks(body, tmp_path):
    field = body.field(resolution=12)
    writer = clsdf.FieldWriter(tmp_path / "x.nrrd", field.grid, field.band, field.sign)
    shown = [body, field, field.grid, field.band, body.device, body.device.info(), body.topology, body.query((0, 0, 0)),
             body.blocks(field.grid, [], (2, 2, 2)), body.plan(field.grid), writer, clsdf.Region((0, 0, 0), (1, 1, 1), 1)]
    assert not [thing for thing in map(repr, shown) if " object at " in thing]
    assert repr(writer) == f"<clsdf.FieldWriter: {tmp_path / 'x.nrrd'}>"
    assert field.shape == field.distance.shape and field._repr_png_() == clsdf.slice_picture(field).png()
    assert repr(clsdf.slice_picture(field)).startswith("<clsdf.Picture: ")
    assert repr(clsdf.trimesh.ProximityQuery("mesh")) == "<clsdf.trimesh.ProximityQuery: 'mesh'>"
    links, crossings = body.links(field.grid, "D3Q19"), body.crossings(field.grid)
    rays = body.rays((0, 0, 0), np.full((1000, 3), 0.5), most=2)
    groups = [f"group {i}" for i in range(1000)], np.arange(len(body.faces)) % 1000
    mesh = clsdf.Mesh(body.vertices, body.faces, groups)
    arrays = [links, crossings, crossings.x, rays, clsdf.fractions(body, field.grid), clsdf.outer(body), mesh, mesh.groups]
    for thing in arrays:
        for text in (repr(thing), str(thing), f"{thing}"):
            assert text.startswith(f"<clsdf.{type(thing).__name__}") and len(text) < 200 and "\n" not in text, text
    assert repr(rays) == "<clsdf.Rays: 1000 hits in arrays of shape (1000, 2)>"
    assert repr(body.rays((0, 0, 0), (1, 0, 0), limit=1e-9)) == f"<clsdf.Rays: t inf, triangle {clsdf.no_triangle}>"
    assert str(inspect.signature(clsdf.Grid)) == "(origin, spacing, size, first=(0, 0, 0))"
    assert str(inspect.signature(clsdf.Band)) == "(inside, outside=None, *, exact_signs=False)"


def test_everything_public_has_a_signature_and_a_documentation():
    for name in clsdf.__all__:
        thing = getattr(clsdf, name)
        for member, value in vars(thing).items() if isinstance(thing, type) else ((name, thing),):
            value = value.__func__ if isinstance(value, staticmethod) else value
            if callable(value) and not member.startswith("_"):
                assert inspect.signature(value) and value.__doc__, f"{name}.{member}"
    position = inspect.signature(clsdf.Grid.position)
    assert str(position) == "(self, i: 'int', j: 'int', k: 'int') -> 'tuple[float, float, float]'"
    assert inspect.signature(clsdf.Grid.between).parameters["cells"].default is None
    assert inspect.signature(clsdf.Device.limited).parameters["memory"].default is None
    assert clsdf.Body is clsdf.Transform


def test_completion_shows_what_is_public():
    shown = {name for name in dir(clsdf) if not name.startswith("_")}
    assert shown - {"jax", "torch"} == set(clsdf.__all__)  # these two from their import on
    for name in clsdf.__all__:
        if isinstance(getattr(clsdf, name), type):
            assert getattr(clsdf, name).__module__ == "clsdf", name


def test_grids_and_bands_say_what_they_take(body):
    grid = clsdf.Grid((0, 0, 0), 0.1, 4)
    assert grid.size == (4, 4, 4) and grid == clsdf.Grid([0, 0, 0], np.full(3, 0.1), np.array([4, 4, 4]))
    assert grid.block((1, 0, 0), 2) == grid.block((1, 0, 0), (2, 2, 2)) and clsdf.Band(0.1) == clsdf.Band(0.1, 0.1)
    wrong = {
        r"size: expected a whole number or three .* not \(4.0, 4, 4\)": lambda: clsdf.Grid((0, 0, 0), 0.1, (4.0, 4, 4)),
        r"size: .* not 4.5": lambda: clsdf.Grid((0, 0, 0), 0.1, 4.5),
        r"spacing: expected a number or three": lambda: clsdf.Grid((0, 0, 0), "0.1", 4),
        r"origin: expected three numbers": lambda: clsdf.Grid((0, 0), 0.1, 4),
        r"first: expected three whole numbers.* not \(0.0, 0, 0\)": lambda: grid.block((0.0, 0, 0), (1, 1, 1)),
        r"i: 0.5 is not a whole number": lambda: grid.position(0.5, 0, 0),
        r"inside is '3v'; write a number.*3 \* grid.voxel": lambda: clsdf.Band("3v"),
        r"inside is missing": lambda: clsdf.Band(),
        r"outside is 'full'": lambda: clsdf.Band(1, "full"),
    }
    for message, call in wrong.items():
        with pytest.raises(clsdf.InvalidArgument, match=message):
            call()
