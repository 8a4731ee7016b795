"""Scenes: many bodies with poses."""

import pickle
import threading

import clsdf
import numpy as np
import pytest
from brute_force import BruteForce

SEED = 20


def turned(angle, axis):
    """The rotation by an angle about an axis (Rodrigues)."""
    x, y, z = np.asarray(axis, float) / np.linalg.norm(axis)
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross


def pose_of(rotation, translation):
    pose = np.eye(4)
    pose[:3, :3], pose[:3, 3] = rotation, translation
    return pose


def cube(half):
    corners = np.array([[x, y, z] for z in (-half, half) for y in (-half, half) for x in (-half, half)], float)
    faces = [(0, 2, 1), (1, 2, 3), (4, 5, 6), (5, 7, 6), (0, 1, 4), (1, 5, 4), (2, 6, 3), (3, 6, 7), (0, 4, 2), (2, 4, 6),
             (1, 3, 5), (3, 7, 5)]
    return corners, np.array(faces)


@pytest.fixture
def random():
    print("seed", SEED)
    return np.random.default_rng(SEED)


def random_poses(random, count, spread):
    return np.stack([
        pose_of(turned(random.uniform(0, 6), random.normal(size=3)), random.uniform(-spread, spread, 3)) for _ in range(count)
    ])


def test_a_scene_has_the_least_distance_of_its_bodies(solid, random):
    meshes = [solid, cube(0.4)]
    scene = clsdf.Scene()
    poses = random_poses(random, 6, 1.5)
    for i, pose in enumerate(poses):
        assert (scene.add(*meshes[i % 2], pose=pose) if i < 2 else scene.add_instance(i % 2, pose)) == i
    assert len(scene) == 6 and scene.has_sign and scene.sign(0) == "nonzero" and "6 bodies" in repr(scene)
    assert scene.memory[0] >= 0 and scene.device.name
    points = random.uniform(-2, 2, (400, 3))
    of_bodies = np.stack([
        BruteForce(meshes[i % 2][0] @ pose[:3, :3].T + pose[:3, 3], meshes[i % 2][1]).distance(points)
        for i, pose in enumerate(poses)
    ])
    found = scene.query(points, "distance closest gradient offset triangle body is_own", dtype="float64")
    assert np.allclose(found.distance, of_bodies.min(0), atol=1e-12) and (found.distance < 0).any()
    assert np.array_equal(found.body, of_bodies.argmin(0)) and found.body.dtype == np.uint32
    assert found.is_own.dtype == bool and found.is_own[found.distance > 0].all() and not found.is_own.all()
    assert np.allclose(points + found.offset, found.closest, atol=1e-12)
    assert np.allclose(-found.gradient * found.distance[:, None], found.offset, atol=1e-12)
    assert np.array_equal(scene.contains(points), of_bodies.min(0) < 0)
    assert np.allclose(scene.winding(points), (of_bodies < 0).sum(0), atol=1e-9)
    pairs = np.stack([random.integers(0, 400, 50), random.integers(0, 6, 50)], 1)
    of_pairs = scene.query_pairs(points, pairs, "offset", dtype="float64")
    assert np.allclose(of_pairs.distance, of_bodies[pairs[:, 1], pairs[:, 0]], atol=1e-12)
    assert of_pairs.offset.shape == (50, 3)
    near = scene.query(points, "body triangle is_own", within=0.05)
    is_far = np.abs(of_bodies.min(0)) > 0.05
    assert (near.body[is_far] == clsdf.no_body).all() and (near.triangle[is_far] == clsdf.no_triangle).all()
    assert near.is_own[is_far].all() and np.allclose(np.abs(near.distance[is_far]), 0.05)


def test_shapes_of_points_and_arrays_that_are_given(random):
    scene = clsdf.Scene()
    scene.add(cube(1))
    points = random.uniform(-2, 2, (4, 5, 3))
    found = scene.query(points, ["gradient", "body", "is_own"])
    assert found.distance.shape == found.body.shape == found.is_own.shape == (4, 5) and found.gradient.shape == (4, 5, 3)
    out = {"distance": np.empty((4, 5)), "body": np.empty((4, 5), np.uint32), "is_own": np.empty((4, 5), np.uint8)}
    given = scene.query(points.astype(np.float32), out=out)
    assert given.body is out["body"] and np.allclose(out["distance"], found.distance, atol=1e-6)
    assert np.array_equal(out["is_own"], found.is_own) and np.array_equal(out["body"], found.body)
    one = scene.query((0, 0, 3), "closest body is_own")
    assert one.distance == 2 and np.allclose(one.closest, [0, 0, 1]) and one.body == 0 and one.is_own
    assert scene.contains((0, 0, 0)).shape == () and scene.contains((0, 0, 0)) and scene.winding((0, 0, 0)) == 1
    assert len(scene.query([])) == 0 and len(scene.query_pairs(points, [])) == 0
    assert scene.classify([[(-0.1,) * 3, (0.1,) * 3], [(2,) * 3, (3,) * 3], [(0.5,) * 3, (1.5,) * 3]], 0.1).tolist() == [
        clsdf.BoxPlace.INSIDE, clsdf.BoxPlace.OUTSIDE, clsdf.BoxPlace.WITHIN
    ]
    with pytest.raises(AttributeError, match="body"):
        scene.query(points).body


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
@pytest.mark.parametrize("kind", ["(n, 4, 4)", "(n, 3, 4)", "tuple", "some"])
def test_poses_in_each_form(random, dtype, kind):
    scene = clsdf.Scene()
    scene.add(cube(1))
    scene.add_instance(0)
    poses = random_poses(random, 2, 3).astype(dtype)
    if kind == "(n, 4, 4)":
        scene.set_poses(poses)
    elif kind == "(n, 3, 4)":
        scene.set_poses(poses[:, :3])
    elif kind == "tuple":
        scene.set_poses((poses[:, :3, :3], poses[:, :3, 3]))
    else:
        scene.set_poses(poses[::-1], bodies=[1, 0])
    for body in range(2):
        used = scene.pose(body)
        assert abs(used - poses[body]).max() < 1e-6 and used[3].tolist() == [0, 0, 0, 1]
        assert abs(used[:3, :3] @ used[:3, :3].T - np.eye(3)).max() < 2e-15
        # As set_motion() and frame= have it.
        rotation, translation = clsdf.Transform(cube(1)).set_motion(poses[body])
        assert abs(rotation - used[:3, :3]).max() < 2e-15 and np.array_equal(translation, used[:3, 3])
    again = clsdf.Scene()
    assert again.add(cube(1), pose=poses[0]) == 0 and again.add_instance(0, (poses[1][:3, :3], poses[1][:3, 3])) == 1
    assert all(np.array_equal(again.pose(body), scene.pose(body)) for body in range(2))


def test_bodies_are_switched_and_deformed():
    scene = clsdf.Scene()
    scene.add(cube(1))
    scene.add_instance(0, pose=pose_of(np.eye(3), (5, 0, 0)))
    points = [(0, 0, 3), (5, 0, 3)]
    scene.set_active(1, False)
    assert not scene.is_active(1) and scene.is_active(0)
    assert scene.query(points, "body").body.tolist() == [0, 0]
    scene.set_active(1)
    scene.set_positions(0, 2 * cube(1)[0])
    found = scene.query(points, "body")
    assert found.body.tolist() == [0, 1] and np.allclose(found.distance, 1)


def test_many_threads_ask_while_one_moves_the_bodies(random):
    scene = clsdf.Scene()
    scene.add(cube(1))
    points = random.uniform(-3, 3, (500, 3))
    shift = np.float64([10, 0, 0])
    expected = [scene.query(points).distance]
    scene.set_poses([pose_of(np.eye(3), shift)])
    expected.append(scene.query(points).distance)
    wrong = []

    def ask():
        for _ in range(20):
            found = scene.query(points).distance
            if not any(np.array_equal(found, one) for one in expected):
                wrong.append(found)

    threads = [threading.Thread(target=ask) for _ in range(3)]
    for thread in threads:
        thread.start()
    for i in range(20):
        scene.set_poses([pose_of(np.eye(3), i % 2 * shift)])
    for thread in threads:
        thread.join()
    assert not wrong


POINT = [(0.0, 0.0, 3.0)]


@pytest.mark.parametrize(
    "call, message",
    [
        (lambda s: s.set_poses(np.stack([np.eye(4), np.diag([1, 1, -1, 1.0])])), "body 1 is no rotation"),
        (lambda s: s.set_poses(np.stack([np.eye(4), np.diag([1.1, 1, 1, 1.0])])), "body 1 is no rotation"),
        (lambda s: s.set_poses(np.stack([np.eye(4), np.ones((4, 4))])), r"last row of matrix 1 is .* not \[0, 0, 0, 1\]"),
        (lambda s: s.set_poses(np.stack([np.eye(4), pose_of(np.eye(3), (0, np.nan, 0))])), "translation of body 1 .* finite"),
        (lambda s: s.set_poses([np.eye(4)]), "1 poses and 2 bodies"),
        (lambda s: s.set_poses([np.eye(4)], bodies=[2]), "no body 2"),
        (lambda s: s.set_poses([np.eye(4)] * 2, bodies=[1, 1]), "named twice"),
        (lambda s: s.set_poses(np.eye(4)), r"shape \(4, 4\)"),
        (lambda s: s.set_poses((np.eye(3), np.zeros(3))), r"shapes \(3, 3\) and \(3,\)"),
        (lambda s: s.set_poses("what"), "no array of numbers"),
        (lambda s: s.set_poses([np.eye(4)], bodies=[0.5]), "whole numbers"),
        (lambda s: s.add_instance(7), "no body 7"),
        (lambda s: s.add_instance(-1), "no body -1: the scene has 2"),
        (lambda s: s.add_instance("a"), "no whole number"),
        (lambda s: s.add(cube(1), pose=np.eye(3)), r"pose has the shape \(3, 3\)"),
        (lambda s: s.add(cube(1), sign="below"), "below"),
        (lambda s: s.add(cube(1), sign="what"), "sign 'what' is not known"),
        (lambda s: s.add(np.empty((0, 3)), np.empty((0, 3), int)), "there is no triangle"),
        (lambda s: s.set_active(2, False), "no body 2"),
        (lambda s: s.set_positions(0, np.zeros((3, 3))), "3"),
        (lambda s: s.query(POINT, within=-1), "half width"),
        (lambda s: s.query(POINT, "distance bodies"), "no output 'bodies'"),
        (lambda s: s.query(POINT, out={"distance": np.empty(1), "body": np.empty(1, np.int64)}), "type uint32 or int32"),
        (lambda s: s.query(POINT, out={"distance": np.empty(1), "body": np.empty(2, np.uint32)}), r"'body' has the shape \(2,\); expected \(1,\)"),
        (lambda s: s.query_pairs(POINT, [(1, 0)]), "pair 0 names point 1"),
        (lambda s: s.query_pairs(POINT, [(0, 2)]), "pair 0 names body 2"),
        (lambda s: s.query_pairs(POINT, [(0.5, 0)]), "whole numbers"),
        (lambda s: s.query_each(POINT, bodies=[9]), "no body 9; the scene has 2"),
        (lambda s: s.query_poses(POINT, np.ones((3, 2, 4, 4))), "last row of body 0 in configuration 0"),
        (pickle.dumps, "add its meshes again"),
        (lambda s: s.query_pairs(POINT, [(-1, 0)]), "count from 0"),
        (lambda s: s.query([(np.nan, 0, 0)], refuse_unusable_points=True), "not finite"),
    ],
)
def test_what_is_wrong_is_named_and_changes_nothing(call, message):
    scene = clsdf.Scene()
    scene.add(cube(1))
    scene.add_instance(0, pose_of(np.eye(3), (8, 0, 0)))
    with pytest.raises(clsdf.Error, match=message):
        call(scene)
    assert np.array_equal(scene.box, [(-1, -1, -1), (9, 1, 1)])
    assert len(scene) == 2 and scene.query(POINT).distance == 2 and scene.query([(8, 0, 3)]).distance == 2


def test_a_scene_without_bodies_is_named():
    scene = clsdf.Scene()
    with pytest.raises(clsdf.InvalidArgument, match="has no bodies"):
        scene.query(POINT)
    scene.add(cube(1))
    scene.set_active(0, False)
    with pytest.raises(clsdf.InvalidArgument, match="all 1 bodies"):
        scene.contains(POINT)
    with pytest.raises(clsdf.Error, match="kept_bytes"):
        clsdf.Scene(kept_bytes=-1)
    scene.set_active(0)
    with pytest.warns(clsdf.MeshWarning) as warned:
        assert np.isnan(scene.query([(np.nan, 0, 0)]).distance)
    assert warned[0].filename == __file__


def least_of(transforms, grid, band):
    """The least of the bodies' fields, and the lowest body that has it within the band."""
    fields = [transform.field(grid, band=band, outputs="triangle gradient") for transform in transforms]
    distance = np.stack([f.distance for f in fields])
    least = distance.min(0)
    body = np.full(least.shape, clsdf.no_body, np.uint32)
    for number in reversed(range(len(fields))):
        of_body = fields[number]
        has_it = (of_body.distance == least) & (of_body.triangle != clsdf.no_triangle)
        body[has_it] = number
    for of_body in fields:
        body[(of_body.distance == least) & (of_body.triangle == clsdf.no_triangle) & (least < 0)] = clsdf.no_body
    return least, body, fields


def test_a_field_has_the_least_distance_and_its_body(solid, random):
    meshes = [solid, cube(0.4)]
    scene, transforms = clsdf.Scene(), []
    for i, pose in enumerate(random_poses(random, 5, 1)):
        scene.add(*meshes[i % 2], pose=pose) if i < 2 else scene.add_instance(i % 2, pose)
        transforms.append(clsdf.Transform(meshes[i % 2]))
        used = scene.pose(i)
        transforms[-1].set_motion(used[:3, :3], used[:3, 3])
    grid = scene.grid(32, band="3v")
    field = scene.field(grid, band="3v", outputs="body triangle gradient")
    least, body, fields = least_of(transforms, grid, "3v")
    assert np.array_equal(field.distance, least) and (least < 0).any()
    assert np.array_equal(field.body, body) and (body == clsdf.no_body).any() and len(np.unique(body)) == 6
    for number, of_body in enumerate(fields):
        at = body == number
        assert np.array_equal(field.triangle[at], of_body.triangle[at])
        assert np.array_equal(field.gradient[at], of_body.gradient[at])
    assert field.sign == "nonzero" and field.mesh_name == "scene" and field.grid == grid
    out = clsdf.Field(grid, field.band, "none", "", {"distance": np.empty(grid.shape), "body": np.empty(grid.shape, np.int32)})
    assert scene.field(out=out) is out and np.allclose(out.distance, field.distance, atol=1e-6)
    assert np.array_equal(out.body, field.body.view(np.int32))
    assert (scene.field(grid, band=0).distance == 0).all()
    assert np.array_equal(scene.field(grid, band="3v", positive_inside=True).distance, -least)
    own = clsdf.Transform(solid).field(resolution=16, outputs="body triangle")
    assert np.array_equal(own.body == 0, own.triangle != clsdf.no_triangle) and (own.body == 0).any()
    with pytest.raises(clsdf.Error, match="bodies"):
        clsdf.Scene().field(grid)


def test_configurations_and_each_body(random):
    scene = clsdf.Scene()
    scene.add(cube(1))
    scene.add_instance(0)
    points = random.uniform(-3, 3, (4, 7, 3))
    poses = np.stack([random_poses(random, 2, 2) for _ in range(6)])
    found = scene.query_poses(points, poses, "closest body is_own", dtype="float64")
    assert found.distance.shape == found.is_own.shape == (6, 4, 7) and found.closest.shape == (6, 4, 7, 3)
    assert np.array_equal(scene.pose(0), np.eye(4))
    for number, of_one in enumerate(poses):
        scene.set_poses(of_one)
        one = scene.query(points, "closest body is_own", dtype="float64")
        for name in one.outputs:
            assert np.array_equal(found[name][number], one[name], equal_nan=name == "closest")
    each = scene.query_each(points, "offset", dtype="float64")
    assert each.distance.shape == (2, 4, 7) and each.offset.shape == (2, 4, 7, 3)
    assert np.array_equal(each.distance.min(0), scene.query(points, dtype="float64").distance)
    assert np.array_equal(scene.query_each(points, bodies=[1], dtype="float64").distance[0], each.distance[1])
    with pytest.raises(clsdf.Error, match="expected"):
        scene.query_poses(points, poses[:, :1])
    poses[3, 1, 0, 0] = 2
    with pytest.raises(clsdf.Error, match="body 1 in configuration 3"):
        scene.query_poses(points, poses)


def test_a_scene_whose_surface_is_outer_has_the_distance_to_the_union(random):
    scene = clsdf.Scene(surface="outer")
    scene.add(*cube(1.0))
    scene.add_instance(0, pose_of(turned(0.5, (1, 2, 3)), (1.2, 0.3, 0.2)))
    points = random.uniform(-2, 3, (2000, 3))
    r = scene.query(points, "closest body is_own", dtype="float64")
    expected = clsdf.Transform(scene.outer().surface.mesh).query(points, dtype="float64").distance
    assert np.allclose(r.distance, expected, rtol=0, atol=1e-13) and (expected < 0).sum() > 100
    assert r.is_own.all() and set(r.body) == {0, 1}
    assert np.allclose(np.linalg.norm(points - r.closest, axis=1), abs(expected), rtol=0, atol=1e-13)
    field = scene.field(scene.grid(16), band="full", outputs="body")
    assert np.allclose(field.distance.min(), expected.min(), atol=0.2) and set(np.unique(field.body)) == {0, 1}
    with pytest.raises(clsdf.Error, match="site"):
        scene.field(scene.grid(16), band="full", outputs="site")
    with pytest.raises(clsdf.Error, match="close_down"):
        scene.add([(0, 0, 0), (1, 0, 0), (0, 1, 0)], [(0, 1, 2)])
    with pytest.raises(clsdf.Error, match="'union' is unknown"):
        clsdf.Scene(surface="union")


def test_the_outer_surface_of_a_scene_is_that_of_the_union(random):
    scene = clsdf.Scene()
    scene.add(*cube(1.0))
    scene.add_instance(0, pose_of(turned(0.5, (1, 2, 3)), (1.2, 0.3, 0.2)))
    points = random.uniform(-2, 3, (2000, 3))
    of_scene = scene.query(points, "is_own", dtype="float64")
    surface, bodies = scene.outer()
    union = clsdf.Transform(surface.mesh)
    depth = union.query(points, dtype="float64").distance
    own = of_scene.is_own
    assert np.allclose(depth[own], of_scene.distance[own], atol=1e-12)
    assert (depth[~own] <= of_scene.distance[~own] + 1e-12).all() and (depth[~own] < of_scene.distance[~own] - 1e-3).any()
    assert set(bodies) == {0, 1} and bodies.shape == surface.faces.shape and surface.faces.max() < 12
    assert 8 < surface.volume < 16 and np.isclose(union.volume, surface.volume)
    grid = union.grid(resolution=20, margin=0.1)
    cells = clsdf.fractions(surface, grid)
    assert np.isclose(cells.dense().sum() * np.prod(grid.spacing), surface.volume, rtol=1e-12)
    with pytest.raises(clsdf.Error, match="body 2"):
        scene.add([(0, 0, 0), (1, 0, 0), (0, 1, 0)], [(0, 1, 2)])
        scene.outer()
