"""Wrong calls are told what to write, in classes that Python programs catch; nothing is taken for what it is not."""

from __future__ import annotations

import copy
import importlib
import types

import numpy as np
import pytest

import clsdf


@pytest.mark.parametrize(
    "code, kind, base",
    [
        ("invalid_argument", clsdf.InvalidArgument, ValueError),
        ("invalid_mesh", clsdf.InvalidMesh, ValueError),
        ("unreadable_input", clsdf.UnreadableInput, OSError),
        ("output_failure", clsdf.OutputFailure, OSError),
        ("out_of_memory", clsdf.OutOfMemory, MemoryError),
        ("unsupported", clsdf.Unsupported, ValueError),
        ("device_failure", clsdf.Error, RuntimeError),
    ],
)
def test_errors_are_those_that_python_knows(code, kind, base):
    import pickle

    error = clsdf.Error("text", code, -4)
    for one in (error, pickle.loads(pickle.dumps(error)), copy.copy(error)):
        assert type(one) is kind and isinstance(one, base) and isinstance(one, clsdf.Error)
        assert (str(one), one.code, one.opencl_code) == ("text", code, -4)


def test_errors_of_the_library_are_those_that_python_knows(body, solid, tmp_path):
    with pytest.raises(OSError, match="nowhere.off"):
        clsdf.read_mesh("/nowhere.off")
    with pytest.raises(ValueError, match="index"):
        clsdf.Transform(solid[0], solid[1] + 10_000)
    with pytest.raises(MemoryError, match="does not fit"):
        body.field(resolution=40_000, band=0.1)
    with pytest.raises(OSError):
        clsdf.write_field(body.field(resolution=8), tmp_path / "no" / "field.npy")


WRONG = {
    "kept_bytes below 0": (lambda b, g: clsdf.Transform(clsdf.make_shape("torus"), kept_bytes=-1), "kept_bytes is not a number of bytes"),
    "kept_bytes as text": (lambda b, g: clsdf.Transform(clsdf.make_shape("torus"), kept_bytes="1G"), "kept_bytes is not a number of bytes"),
    "resolution": (lambda b, g: b.grid(10**30), "resolution: 10+ samples"),
    "resolution as bool": (lambda b, g: b.grid(True), "resolution: True"),
    "within": (lambda b, g: b.query([[0, 0, 0]], within="1"), "within: '1' is not a number.*None is no limit"),
    "band of digits": (lambda b, g: b.field(g, band="10"), "band: '10' is a text without a unit: write the number 10 .*'10%'.*'10v'"),
    "band as bool": (lambda b, g: b.field(g, band=True), "band: True is not a length"),
    "margin of digits": (lambda b, g: b.grid(8, margin="1e1"), "margin: '1e1' is a text without a unit"),
    "region": (lambda b, g: b.restrict_to(((0, 0, 0), (1, 1, 1), 0.1)), r"write clsdf.Region\(lower, upper, half_width, spacing\)"),
    "fields of one grid": (lambda b, g: b.fields(g), "pass a list of grids"),
    "slice_picture": (lambda b, g: clsdf.slice_picture("x"), "'x' is no clsdf.Field"),
    "write_field": (lambda b, g: clsdf.write_field("x", "y.nrrd"), "'x', a str, is no clsdf.Field"),
    "outputs": (lambda b, g: b.field(g, outputs=3), "outputs: 3 is neither a text nor a list of names"),
    "ragged": (lambda b, g: b.query([[0, 0, 0], [1, 2]]), "its rows differ in length"),
    "text as points": (lambda b, g: b.query([["a", "b", "c"]]), "no array of numbers"),
    "ragged mesh": (lambda b, g: clsdf.Transform([[0, 0, 0], [1, 2]], [[0, 1, 2]]), "its rows differ in length"),
    "band of a writer": (lambda b, g: clsdf.FieldWriter("y.nrrd", g, "10%", b.sign), "part of the mesh's box"),
    "grid of a writer": (lambda b, g: clsdf.FieldWriter("y.nrrd", 8, 0.1, b.sign), "grid: 8, a int, is no clsdf.Grid"),
    "spacing beside a grid": (lambda b, g: b.field(g, spacing=np.array([1, 1, 1])), "a grid that is given excludes"),
    "dtype of links": (lambda b, g: b.links(g, dtype="foo"), "dtype: 'foo' is neither"),
    "points of a plan": (lambda b, g: b.plan_points(1e6), "count: 1000000.0 is not a whole number of points"),
    "fewer points": (lambda b, g: b.plan_points(-1), "count: -1 points are too few"),
    "room of links": (lambda b, g: b.plan_links(g, room=1.5), "room: 1.5 is not a whole number of links"),
    "room of bricks": (lambda b, g: b.sparse_plan(g, 100), "room: 100 is not two whole numbers"),
    "half of a brick": (lambda b, g: b.sparse_plan(g, (1.5, 2)), "room: 1.5 is not a whole number of bricks"),
    "memory of a device": (lambda b, g: b.device.limited(memory=2e9), "memory: 2000000000.0 is not a whole number"),
    "units of a device": (lambda b, g: b.device.limited(compute_units=-1), "compute_units: -1 is negative"),
    "boxes of a scene": (lambda b, g: clsdf.Scene().classify(np.zeros((1, 2, 3)), "0.1"), "half_width: '0.1' is not a number"),
    "a plan of requests": (lambda b, g: b.plan([], exact_signs=True), "a Request has its own band and outputs"),
    "corners of a grid": (lambda b, g: clsdf.Grid.between(0, 1, cells=64), "lower: expected three numbers"),
    "ragged boxes": (lambda b, g: b.classify([[[0, 0, 0], [1, 1]]], 0.1), "is no array of numbers"),
    "groups": (lambda b, g: clsdf.write_field(b.field(g), "y.h5", groups=3), "groups: 3 is no clsdf.Groups"),
    "scene": (lambda b, g: clsdf.Transform(types.SimpleNamespace(geometry={}, graph=None)), "scene of meshes: pass scene.to_mesh"),
    "unstructured grid": (
        lambda b, g: clsdf.Transform(types.SimpleNamespace(points=[], cells_dict={10: []}, extract_surface=None)),
        r"no surface: pass mesh.extract_surface\(\).triangulate\(\)",
    ),
}


@pytest.mark.parametrize("name", WRONG)
def test_a_wrong_call_is_told_what_to_write(body, name):
    call, message = WRONG[name]
    with pytest.raises(clsdf.InvalidArgument, match=message):
        call(body, body.grid(8))


class InCuda:
    shape = (2, 3)
    __cuda_array_interface__ = {"shape": (2, 3), "typestr": "<f8", "data": (4096, False), "version": 3}


def test_rays_are_looked_up_by_the_host(body):
    for call in (body.rays, body.any_hit, body.visible):
        with pytest.raises(clsdf.Unsupported, match="is in memory of a device"):
            call(InCuda(), InCuda())


def test_a_writer_takes_lengths_and_fields_alone(body, tmp_path):
    grid = body.grid(8)
    for band, width in ((0.1, 0.1), ("3v", 3 * grid.voxel)):
        with clsdf.FieldWriter(tmp_path / "field.nrrd", grid, band, body.sign) as writer:
            with pytest.raises(clsdf.Error, match="is no clsdf.Field"):
                writer.append(np.zeros(grid.shape))
            writer.append(body.field(grid, band=band))
        assert clsdf.read_field(tmp_path / "field.nrrd").band == clsdf.Band(width)


def test_a_picture_is_saved_as_png_alone(body, tmp_path):
    picture = clsdf.slice_picture(body.field(resolution=8))
    with pytest.raises(clsdf.Error, match="end the path with .png") as error:
        picture.save(tmp_path / "x.jpg")
    assert error.value.code == "unsupported" and not list(tmp_path.iterdir())
    with pytest.raises(clsdf.OutputFailure, match="x.png cannot be written: No such file"):
        picture.save(tmp_path / "no" / "x.png")
    picture.save(tmp_path / "x.PNG")
    old = (tmp_path / "x.PNG").read_bytes()
    picture.png = None
    with pytest.raises(TypeError):
        picture.save(tmp_path / "x.PNG")
    assert [path.name for path in tmp_path.iterdir()] == ["x.PNG"] and (tmp_path / "x.PNG").read_bytes() == old


def test_within_none_is_no_limit(body, points):
    assert np.array_equal(body.query(points, within=None).distance, body.query(points).distance)


def test_a_large_field_is_compared_with_the_memory_there_is(body, tmp_path, monkeypatch):
    memory = importlib.import_module("clsdf._memory")
    group = tmp_path / "group" / "a" / "b"
    group.mkdir(parents=True)
    (tmp_path / "self").mkdir()
    (tmp_path / "meminfo").write_text("MemTotal: 9000000 kB\nMemAvailable: 8000000 kB\n")
    (tmp_path / "self" / "cgroup").write_text("0::/a/b\n")
    assert memory.available(tmp_path, tmp_path / "group") == 8_192_000_000
    (group / "memory.max").write_text("max\n")
    (group / "memory.current").write_text("5\n")
    (group.parent / "memory.max").write_text("3000000000\n")
    (group.parent / "memory.current").write_text("1000000000\n")
    (group.parent / "memory.stat").write_text("anon 5\ninactive_file 400000000\n")
    assert memory.available(tmp_path, tmp_path / "group") == 2_400_000_000
    (tmp_path / "self" / "cgroup").write_text("5:memory:/a\n")
    old = tmp_path / "group" / "memory" / "a"
    old.mkdir(parents=True)
    (old / "memory.limit_in_bytes").write_text("1500000000\n")
    (old / "memory.usage_in_bytes").write_text("500000000\n")
    assert memory.available(tmp_path, tmp_path / "group") == 1_000_000_000
    monkeypatch.setattr(memory, "available", lambda: 1_500_000_000)
    grid = clsdf.Grid((0, 0, 0), 1, (1000, 1000, 400))
    with pytest.raises(MemoryError, match="a field of 1.6 GB does not fit the memory, of which 1.5 GB are available") as error:
        body.field(grid, band=0.1)
    assert error.value.code == "out_of_memory"
    monkeypatch.setattr(memory, "available", lambda: 0)
    body.field(resolution=16)


@pytest.mark.parametrize("copied", [copy.copy, copy.deepcopy])
def test_a_copy_of_a_transform_is_another_one_at_the_present_positions(solid, points, copied):
    body = clsdf.Transform(solid)
    body.set_positions(solid[0] * 1.25)
    other = copied(body)
    expected = body.query(points).distance
    assert other.device.name == body.device.name and np.array_equal(other.query(points).distance, expected)
    other.set_positions(solid[0] + 10)
    assert np.array_equal(body.query(points).distance, expected)
    assert not np.array_equal(other.query(points).distance, expected)
    turn = np.array([[0, -1, 0], [1, 0, 0], [0, 0, 1.0]])
    body.set_motion(turn, (0.5, 0, 0))
    assert np.array_equal(copied(body).query(points).distance, body.query(points).distance)


WRONG_ARGUMENTS = {
    "a direction": (lambda g: clsdf.Grid((0, 0, 0), 0.1, 4, direction=np.eye(3)), r"Grid\(origin, spacing, size, first=.*no argument 'direction'"),
    "no size": (lambda g: clsdf.Grid((0, 0, 0), 0.1), r"Grid\(origin, spacing, size.*'size' is missing"),
    "size twice": (lambda g: clsdf.Grid((0, 0, 0), 0.1, 4, size=4), "'size' is given twice"),
    "five": (lambda g: clsdf.Grid(0, 0, 0, 0, 0), "5 arguments are given"),
    "a tuple as position": (lambda g: g.position((1, 0, 0)), r"Grid.position\(\) missing 2 .*'j' and 'k'"),
    "between": (lambda g: clsdf.Grid.between((0, 0, 0), (1, 1, 1), resolution=3), r"between\(\) got an unexpected .*'resolution'"),
    "limited": (lambda g: clsdf.Device.limited("gpu", 3, 4, 5), r"Device.limited\(\) takes from"),
}


@pytest.mark.parametrize("name", WRONG_ARGUMENTS)
def test_wrong_arguments_of_the_extension_name_the_right_ones(body, name):
    call, message = WRONG_ARGUMENTS[name]
    with pytest.raises(TypeError, match=message) as error:
        call(body.grid(8))
    assert "\n" not in str(error.value)


def test_unsupported_endings_are_wrong_values(body, tmp_path):
    field = body.field(resolution=8)
    for call in (
        lambda: clsdf.Transform("a.glb"),
        lambda: clsdf.read_mesh("a.glb"),
        lambda: clsdf.write_field(field, tmp_path / "x.mha"),
        lambda: field.write(tmp_path / "x.mha"),
        lambda: body.sparse(resolution=16).write(tmp_path / "x.b"),
        lambda: clsdf.read_field("x.y"),
    ):
        with pytest.raises(ValueError) as error:
            call()
        assert isinstance(error.value, clsdf.Unsupported) and error.value.code == "unsupported"
