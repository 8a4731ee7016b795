"""Fields against brute force."""

from __future__ import annotations

import copy
import mmap
import pickle
import subprocess
import sys
import warnings
from multiprocessing import shared_memory

import numpy as np
import pytest
from brute_force import BruteForce, positions

import clsdf


def test_a_sample_is_the_signed_distance_with_z_first(body, brute):
    field = body.field(resolution=24, band="full")
    nx, ny, nz = field.grid.size
    assert len({nx, ny, nz}) == 3  # a wrong order of axes would have another shape
    assert field.distance.shape == (nz, ny, nx) and field.distance.dtype == np.float32
    expected = brute.distance(positions(field.grid).reshape(-1, 3)).reshape(field.distance.shape)
    assert np.allclose(field.distance, expected, atol=1e-6)
    i, j, k = 3, 5, 2
    assert field.distance[k, j, i] == pytest.approx(brute.distance([field.grid.position(i, j, k)])[0], abs=1e-6)
    assert (field.distance < 0).any() and (field.distance > 0).any()


def test_beyond_the_band_is_its_half_width_with_the_sign(body, brute):
    field = body.field(resolution=24, band=(0.05, 0.1))
    assert (field.band.inside, field.band.outside) == (0.05, 0.1)
    expected = brute.distance(positions(field.grid).reshape(-1, 3)).reshape(field.distance.shape)
    assert np.allclose(field.distance, np.clip(expected, -0.05, 0.1), atol=1e-6)


def test_exact_signs_are_below_0_inside_also_on_a_face_within_the_body():
    one = [(x, y, z) for z in (2, 5) for y in (2, 5) for x in (2, 4)]
    faces = [(0, 2, 1), (1, 2, 3), (4, 5, 6), (5, 7, 6), (0, 1, 4), (1, 5, 4)]
    faces += [(2, 6, 3), (3, 6, 7), (0, 4, 2), (2, 4, 6), (1, 3, 5), (3, 7, 5)]
    vertices = np.array(one + [(x + 2, y, z) for x, y, z in one], float)
    both = clsdf.Transform((vertices, np.array(faces + [tuple(v + 8 for v in face) for face in faces])))
    grid = clsdf.Grid((0, 0, 0), (1, 1, 1), (9, 8, 8))
    inside = np.zeros(grid.shape, bool)
    inside[3:5, 3:5, 3:6] = True  # walls are outside
    usual = both.field(grid, band="2v")
    assert usual.distance[3, 3, 4] == 0
    for band in ("2v", 0, "full", clsdf.Band(2)):
        field = both.field(grid, band=band, exact_signs=True)
        assert ((field.distance < 0) == inside).all()
        assert field.band.exact_signs and "exact_signs=True" in repr(field.band)
        assert pickle.loads(pickle.dumps(field.band)) == field.band
    assert (both.fields([grid], exact_signs=True)[0].distance[inside] < 0).all()
    assert (both.sparse(grid, exact_signs=True).distance_at([(4, 3, 3), (3, 4, 4)]) < 0).all()
    assert not usual.band.exact_signs and usual.band != field.band


def test_other_outputs_belong_to_the_nearest_triangle(body, brute, solid):
    field = body.field(resolution=20, band="full", outputs="triangle site closest gradient barycentric offset")
    where = positions(field.grid).reshape(-1, 3)
    nearest = brute.closest(where)
    far = np.linalg.norm(nearest - where[:, None], axis=-1)
    triangle = field.triangle.reshape(-1)
    row = np.arange(len(where))
    assert np.allclose(far[row, triangle], far.min(1), atol=1e-6)
    closest = field.closest.reshape(-1, 3)
    assert np.allclose(closest, nearest[row, triangle], atol=1e-6)
    assert np.allclose(where + field.offset.reshape(-1, 3), closest, atol=1e-6)
    u, v = field.barycentric.reshape(-1, 2).T[:, :, None].astype(float)
    a, b, c = (brute.corners[triangle, corner] for corner in range(3))
    assert np.allclose((1 - u - v) * a + u * b + v * c, closest, atol=1e-5)
    gradient = field.gradient.reshape(-1, 3)
    distance = brute.distance(where)[:, None]
    assert np.allclose(where - distance * gradient, closest, atol=1e-5)
    assert field.site.shape == field.grid.shape and field.site.max() <= 6


@pytest.mark.parametrize(
    "band, width", [("10%", 0.1), ("25%", 0.25), ("3v", "voxels"), (0.07, 0.07), ("full", np.inf)]
)
def test_bands_are_those_of_the_command(body, band, width):
    lower, upper = body.box
    extent = (upper - lower).max()
    field = body.field(resolution=20, band=band)
    if isinstance(band, str) and band.endswith("%"):
        width *= extent
    if width == "voxels":
        width = 3 * field.grid.voxel
    assert field.band.inside == field.band.outside == pytest.approx(width)


@pytest.mark.parametrize("band", ["", "x", "10 %", "-1", -1, "nan", float("nan"), "1_0", "inf", "3vv", (1, 2, 3), ("1", None), {}])
def test_a_band_that_is_no_length_is_refused(body, band):
    with pytest.raises(clsdf.Error, match="band") as error:
        body.field(resolution=8, band=band)
    assert error.value.code == "invalid_argument"


WRONG = {
    "a number as the grid": (lambda body: body.field(32), "32 is not a clsdf.Grid; resolution="),
    "resolution": (lambda body: body.field(resolution=8.5), "resolution: 8.5 is not a whole number"),
    "spacing": (lambda body: body.field(spacing=(1, 2)), r"spacing: \(1, 2\) is neither a number nor three"),
    "spacing as a text": (lambda body: body.field(spacing="3v"), "spacing: '3v' is neither"),
    "corners of blocks": (lambda body: body.blocks(body.grid(8), [[0.5, 0, 0]], (2, 2, 2)), "float64; expected whole"),
    "corners without z": (lambda body: body.blocks(body.grid(8), [[0, 0]], (2, 2, 2)), r"shape \(1, 2\)"),
    "size of blocks": (lambda body: body.blocks(body.grid(8), [[0, 0, 0]], 2), "size: 2 is not three"),
    "boxes": (lambda body: body.classify(np.zeros((4, 6)), 0.1), r"shape \(4, 6\); expected \(n, 2, 3\)"),
    "one point": (lambda body: body.query((1, 2)), r"shape \(2,\); expected .*\(3,\) of one point"),
    "a number as points": (lambda body: body.query(np.float64(3)), r"shape \(\); expected .*\(3,\) of one point"),
    "rotation": (lambda body: body.set_motion(np.eye(4), (0, 0, 0)), r"rotation has the shape \(4, 4\); expected \(3, 3\)"),
    "translation": (lambda body: body.set_motion(np.eye(3), 0), r"translation has the shape \(\); expected \(3,\)"),
    "within": (lambda body: body.query((1, 2, 3), within="3v"), "within: '3v' is not a number"),
    "refined": (lambda body: body.grid(8).refined(1.5), r"refined\(\): ratio: 1.5 is not a whole number"),
    "refined cells": (lambda body: body.grid(8).refined_cells("2"), "ratio: '2' is not a whole number"),
    "grown": (lambda body: body.grid(8).grown(0.5), "samples: 0.5 is not a whole number"),
    "rank": (lambda body: clsdf.Device.of_rank(-1, 2), "rank: -1 is negative"),
    "ranks": (lambda body: clsdf.Device.of_rank(0, 2.5), "ranks: 2.5 is not a whole number"),
}


@pytest.mark.parametrize("name", WRONG)
def test_a_wrong_option_is_an_error_of_the_package(body, name):
    call, message = WRONG[name]
    with pytest.raises(clsdf.Error, match=message) as error:
        call(body)
    assert error.value.code == "invalid_argument"


def test_options_are_also_numbers_of_numpy_and_lists(body):
    assert body.grid(np.int64(20)) == body.grid(20)
    assert body.grid(spacing=np.float32(0.25)) == body.grid(spacing=0.25) == body.grid(spacing=[0.25] * 3)
    assert body.field(resolution=8, band=[0.1, 0.2]).band == clsdf.Band(0.1, 0.2)
    assert clsdf.Band(0.1) == clsdf.Band(0.1, 0.1) and clsdf.Band(0) == clsdf.Band(0, 0)


def test_equal_grids_and_bands_have_equal_hashes(body):
    grids = {body.grid(8), body.grid(8), body.grid(9), body.grid(8).part((1, 0, 0), (2, 2, 2))}
    assert len(grids) == 3
    assert len({clsdf.Band(0, 1), clsdf.Band(-0.0, 1), clsdf.Band(1, 0)}) == 2


def test_names_of_outputs_are_a_text_or_a_list(body):
    for outputs in ("triangle gradient", "gradient,triangle", "gradient, triangle", ["triangle", "gradient"]):
        assert body.query((1, 2, 3), outputs).outputs == ("distance", "triangle", "gradient")


def test_names_of_outputs_may_be_a_generator(body, monkeypatch):
    from clsdf import _core

    def names():
        return (name for name in ("distance", "gradient"))

    grid = body.grid(12)
    monkeypatch.setattr(_core, "slabs_of", lambda whole: [whole, whole])
    for fields in (body.fields([grid, grid], outputs=names()), list(body.slabs(grid, outputs=names()))):
        assert [field.outputs for field in fields] == [("distance", "gradient")] * 2
    with pytest.raises(clsdf.Error, match="outputs= names distance, gradient;"):
        body.field(grid, outputs=names(), out=body.field(grid))


def test_a_field_as_out_keeps_its_grid_and_band(body):
    field = body.field(resolution=20, band="3v")
    band, distance = field.band, field.distance.copy()
    assert body.field(out=field) is field and field.band == band
    assert np.array_equal(field.distance, distance)
    body.field(out=field, band="5%")
    assert field.band != band


def test_signs_alone(body, brute):
    field = body.field(resolution=20, band=0)
    inside = brute.winding(positions(field.grid).reshape(-1, 3)).round().reshape(field.grid.shape) != 0
    assert not field.distance.any()
    assert np.array_equal(np.signbit(field.distance), inside)


def test_grids_around_the_mesh(body):
    lower, upper = body.box
    grid = body.grid(33, margin="10%")
    longest = int(np.argmax(upper - lower))
    assert max(grid.size) == grid.size[longest] == 33
    first, last = grid.box
    assert first[longest] == pytest.approx(lower[longest] - 0.1 * (upper - lower).max())
    assert body.grid(spacing=0.1).spacing == (0.1, 0.1, 0.1)
    assert body.grid(spacing=(0.1, 0.2, 0.3)).spacing == (0.1, 0.2, 0.3)
    assert body.grid(16, cubic=True).size == (16, 16, 16)
    nodes, cells = body.grid(16), body.grid(16, cell_centred=True)
    assert np.allclose(np.subtract(cells.origin, nodes.origin), np.array(nodes.spacing) / 2)
    with pytest.raises(clsdf.Error, match="exclude"):
        body.grid(16, spacing=0.1)
    with pytest.raises(clsdf.Error, match="excludes"):
        body.field(grid, resolution=16)


def test_positive_inside(body, solid, points, tmp_path):
    usual = body.field(resolution=16, outputs="gradient site")
    turned = body.field(usual.grid, band=usual.band, outputs="gradient site", positive_inside=True)
    assert turned.positive_inside and not usual.positive_inside
    assert np.array_equal(turned.distance, -usual.distance) and np.array_equal(turned.site, usual.site)
    assert np.array_equal(turned.gradient, -usual.gradient, equal_nan=True)
    planes = np.empty((3, *usual.grid.shape)[::-1], np.float64).T
    out = {"distance": np.empty(usual.grid.shape, np.float64, "F"), "gradient": np.moveaxis(planes, 0, -1)}
    body.field(usual.grid, band=usual.band, out=out, positive_inside=True)
    assert np.allclose(out["distance"], turned.distance, atol=1e-6)
    assert np.allclose(out["gradient"], turned.gradient, atol=1e-6, equal_nan=True)
    for ending in (".nrrd", ".npy", ".vti", ".h5"):
        clsdf.write_field(turned, tmp_path / ("field" + ending))
        read = clsdf.read_field(tmp_path / ("field" + ending))
        assert read.positive_inside and np.array_equal(read.distance, turned.distance)
    assert np.array_equal(clsdf.slice_picture(turned, axes=False).pixels, clsdf.slice_picture(usual, axes=False).pixels)
    assert all(slab.positive_inside for slab in body.slabs(usual.grid, band=usual.band, positive_inside=True))
    r, t = body.query(points, "gradient"), body.query(points, "gradient", positive_inside=True)
    assert np.array_equal(t.distance, -r.distance) and np.array_equal(t.gradient, -r.gradient, equal_nan=True)
    with pytest.raises(clsdf.Error, match="positive_inside: a field of signs alone"):
        body.field(usual.grid, band=0, positive_inside=True)
    vertices, faces = solid
    with pytest.raises(clsdf.Error, match="positive_inside: the distances have no sign"):
        clsdf.Transform(vertices, faces, sign="none").query(points, positive_inside=True)


def test_grids_from_corner_to_corner():
    grid = clsdf.Grid.between((-1, -1, 0), (1, 1, 1), cells=(64, 64, 32))
    assert grid.origin == (-1, -1, 0) and grid.size == (65, 65, 33) and grid.box[1] == (1, 1, 1)
    assert grid == clsdf.Grid.between([-1, -1, 0], np.array([1, 1, 1]), samples=(65, 65, 33))
    centred = clsdf.Grid.between((-1, -1, -1), (1, 1, 1), cells=64, cell_centred=True)
    assert centred.size == (64, 64, 64) and centred.origin == (-1 + 1 / 64,) * 3
    slice_ = clsdf.Grid.between((0, 0, 2), (1, 1, 2), samples=(41, 41, 1))
    assert slice_.size == (41, 41, 1) and slice_.box == ((0, 0, 2), (1, 1, 2)) and slice_.spacing == (0.025,) * 3
    with pytest.raises(clsdf.Error, match="1 sample along z.*same coordinate in both corners"):
        clsdf.Grid.between((0, 0, 0), (1, 1, 1), samples=(41, 41, 1))
    for wrong in ({}, {"samples": 3, "cells": 2}, {"samples": 1}, {"cells": "many"}, {"samples": 3, "cell_centred": True}):
        with pytest.raises(clsdf.Error, match="samples|cells"):
            clsdf.Grid.between((0, 0, 0), (1, 1, 1), **wrong)


def test_without_a_margin_the_longest_side_begins_at_the_corner():
    vertices, faces = clsdf.make_shape("cube")
    body = clsdf.Transform(vertices * 0.5 + 0.5, faces)
    for resolution in (11, 16, 32):
        assert body.grid(resolution, margin=0).origin == tuple(body.box[0])


def test_a_grid_of_your_own(body, brute):
    grid = clsdf.Grid(origin=np.array([-1, -0.5, -0.25]), spacing=0.125, size=(9, 5, 7), first=(1, 2, -3))
    field = body.field(grid, band="full")
    assert field.grid == grid and field.distance.shape == (7, 5, 9)
    expected = brute.distance(positions(grid).reshape(-1, 3)).reshape(7, 5, 9)
    assert np.allclose(field.distance, expected, atol=1e-6)
    part = grid.part((2, 1, 3), (4, 3, 2))
    assert np.array_equal(body.field(part, band="full").distance, field.distance[3:5, 1:4, 2:6])
    with pytest.raises(clsdf.Error, match="spacing"):
        clsdf.Grid((0, 0, 0), -1.0, (2, 2, 2))


def test_slabs_are_the_whole(body, monkeypatch):
    from clsdf import _core

    whole = body.field(resolution=24, outputs="distance closest")
    parts = [whole.grid.part((0, 0, k), (*whole.grid.size[:2], min(5, whole.grid.size[2] - k)))
             for k in range(0, whole.grid.size[2], 5)]
    monkeypatch.setattr(_core, "slabs_of", lambda grid: parts)
    slabs = list(body.slabs(resolution=24, outputs="distance closest"))
    assert [slab.grid for slab in slabs] == parts
    assert np.array_equal(np.concatenate([slab.distance for slab in slabs]), whole.distance)
    assert np.array_equal(np.concatenate([slab.closest for slab in slabs]), whole.closest, equal_nan=True)


def test_the_slabs_of_a_large_grid_tile_it(body):
    from clsdf import _core

    grid = clsdf.Grid((0, 0, 0), 1.0, (1000, 1000, 100))
    parts = _core.slabs_of(grid)
    assert len(parts) > 1
    assert sum(part.size[2] for part in parts) == 100
    assert all(part.size[:2] == grid.size[:2] for part in parts)


def test_many_boxes_have_the_bytes_of_each(body):
    whole = body.grid(24)
    grids = [whole.part((0, 0, 0), (5, 6, 7)), clsdf.Grid((0, 0, 0), 0.1, (4, 4, 4)), whole.grown(2)]
    fields = body.fields(grids, band="5%", outputs="distance gradient")
    for grid, field in zip(grids, fields):
        alone = body.field(grid, band="5%", outputs="distance gradient")
        assert field.grid == grid
        assert np.array_equal(field.distance, alone.distance)
        assert np.array_equal(field.gradient, alone.gradient, equal_nan=True)


def test_requests_are_refused_by_their_index(body):
    grid, band = body.grid(8), clsdf.Band(1, 1)
    good = clsdf.Request(grid, band, {"distance": np.full(grid.shape, 7, np.float32)})
    far = clsdf.Request(clsdf.Grid((0, 0, 0), 1e-9, (2, 2, 2), (2**50, 0, 0)), band, {"distance": np.empty((2, 2, 2), "f4")})
    with pytest.raises(clsdf.Error, match="request 1"):
        body.compute([good, far])
    assert (good.out["distance"] == 7).all()
    small = clsdf.Request(grid, band, {"distance": np.empty((2, 2, 2), np.float32)})
    with pytest.raises(clsdf.Error, match=r"request 1: .*shape \(2, 2, 2\)"):
        body.compute([good, small])
    for wrong in (7, (grid, band), (grid, None, good.out), ("grid", band, good.out), (grid, band, good.out["distance"])):
        with pytest.raises(clsdf.Error, match="request 1|band"):
            body.compute([good, wrong])
    assert (good.out["distance"] == 7).all()
    body.compute([good])
    assert np.array_equal(good.out["distance"], body.field(grid, band=band).distance)
    text = clsdf.Request(grid, "3v", {"distance": np.empty(grid.shape, np.float32)})
    body.compute([text])
    assert np.array_equal(text.out["distance"], body.field(grid, band="3v").distance)


def test_blocks_have_the_bytes_of_the_lattice(body):
    whole = body.field(resolution=24, outputs="distance gradient")
    first = np.array([[0, 0, 0], [4, 5, 6], [8, 2, 1]])
    blocks = body.blocks(whole.grid, first, (4, 3, 2), band=whole.band, outputs="distance gradient")
    assert blocks.distance.shape == (3, 2, 3, 4) and blocks.gradient.shape == (3, 2, 3, 4, 3)
    for n, (i, j, k) in enumerate(first):
        assert np.array_equal(blocks.distance[n], whole.distance[k : k + 2, j : j + 3, i : i + 4])
        assert np.array_equal(blocks.gradient[n], whole.gradient[k : k + 2, j : j + 3, i : i + 4], equal_nan=True)
    every_other = np.zeros((6, 2, 3, 4), np.float64)
    body.blocks(whole.grid, first, (4, 3, 2), band=whole.band, out=every_other[::2])
    assert np.allclose(every_other[::2], blocks.distance, atol=1e-6) and not every_other[1::2].any()


def test_an_output_that_was_not_asked_for_says_so(body):
    field = body.field(resolution=8)
    assert field.outputs == ("distance",)
    with pytest.raises(AttributeError, match="outputs='distance gradient'"):
        field.gradient
    with pytest.raises(clsdf.Error, match="no output 'normal'.*gradient"):
        body.field(resolution=8, outputs="normal")


def test_a_field_is_copied_and_pickled(body):
    import copy
    import pickle

    field = body.field(resolution=12, band=("5%", "full"), outputs="triangle")
    for other in (copy.deepcopy(field), pickle.loads(pickle.dumps(field))):
        assert (other.grid, other.band, other.sign, other.outputs) == (field.grid, field.band, field.sign, field.outputs)
        assert np.array_equal(other.triangle, field.triangle) and other.triangle is not field.triangle


@pytest.mark.parametrize("resolution", [40_000, 500_000_000])
def test_a_field_that_fits_no_memory(body, resolution):
    with pytest.raises(clsdf.Error, match="does not fit the memory") as error:
        body.field(resolution=resolution, band=0.1, outputs="closest")
    assert error.value.code == "out_of_memory"


def test_axes_and_other_packages_arrays(body):
    field = body.field(resolution=12, outputs="distance gradient")
    x, y, z = field.axes()
    assert np.allclose(np.stack(np.meshgrid(z, y, x, indexing="ij")[::-1], -1), positions(field.grid))
    xarray = pytest.importorskip("xarray")
    data = field.to_xarray()
    assert isinstance(data, xarray.Dataset)
    assert float(data.distance.sel(x=x[3], y=y[2], z=z[1])) == field.distance[1, 2, 3]
    assert data.distance.values.ctypes.data == field.distance.ctypes.data


def test_an_image_of_pyvista(body):
    pytest.importorskip("pyvista")
    field = body.field(resolution=12, outputs="distance gradient")
    image = field.to_pyvista()
    n = image.find_closest_point(field.grid.position(3, 2, 1))
    assert np.allclose(image.points[n], field.grid.position(3, 2, 1))
    assert image.point_data["distance"][n] == field.distance[1, 2, 3]
    assert np.array_equal(image.point_data["gradient"].reshape(field.gradient.shape), field.gradient, equal_nan=True)


def test_pyvista_reads_xdmf(body, tmp_path):
    pyvista = pytest.importorskip("pyvista")
    field = body.field(resolution=12)
    field.write(tmp_path / "x.h5")
    image = pyvista.read(tmp_path / "x.xdmf")
    image = image[0] if isinstance(image, pyvista.MultiBlock) else image
    assert np.array_equal(image.point_data["distance"].reshape(field.shape), field.distance)


def test_a_picture_is_a_png_of_the_slice(body):
    field = body.field(resolution=24)
    picture = clsdf.slice_picture(field, "y", pixels=100, axes=False)
    png = picture._repr_png_()
    assert png.startswith(b"\x89PNG\r\n\x1a\n") and png.endswith(b"IEND\xaeB`\x82")
    nz, _, nx = field.distance.shape
    scale = picture.pixels.shape[0] // nz
    assert picture.pixels.shape == (nz * scale, nx * scale, 3) and nx * scale <= 100
    # Blue inside, orange outside; the first row is the upper end of z.
    middle = picture.pixels[(nz // 2) * scale + 1, (nx // 2) * scale + 1].astype(int)
    corner = picture.pixels[1, 1].astype(int)
    assert middle[2] > middle[0] and corner[0] > corner[2]
    with pytest.raises(clsdf.Error, match="axis"):
        clsdf.slice_picture(field, "w")
    with pytest.raises(clsdf.Error, match="no slice 99"):
        clsdf.slice_picture(field, "x", 99)


def test_positions_and_motions(solid, points):
    vertices, faces = solid
    body = clsdf.Transform(solid)
    moved = vertices * 1.5 + 0.1
    body.set_positions(moved)
    assert np.allclose(body.query(points).distance, BruteForce(moved, faces).distance(points), atol=1e-6)
    assert np.allclose(body.box, [moved.min(0), moved.max(0)])
    turn = np.array([[0, -1, 0], [1, 0, 0], [0, 0, 1.0]])
    body.set_motion(turn, (0.5, 0, 0))
    turned = vertices @ turn.T + (0.5, 0, 0)
    assert np.allclose(body.query(points).distance, BruteForce(turned, faces).distance(points), atol=1e-6)
    with pytest.raises(clsdf.Error, match="positions"):
        body.set_positions(vertices[1:])
    bad = vertices.copy()
    bad[4, 2] = np.inf
    with pytest.raises(clsdf.Error, match="vertex 4.*inf"):
        body.set_positions(bad)
    with pytest.raises(clsdf.Error, match="rotation"):
        body.set_motion(2 * turn, (0, 0, 0))
    assert np.allclose(body.query(points).distance, BruteForce(turned, faces).distance(points), atol=1e-6)


def test_many_boxes_are_classified_as_each(body, points):
    boxes = np.stack([points, points + 0.05], 1)
    many = np.tile(boxes, (140, 1, 1))  # more than are classified at once
    assert np.array_equal(body.classify(many, 0.1), np.tile(body.classify(boxes, 0.1), 140))
    assert len(body.classify(np.empty((0, 2, 3)), 0.1)) == 0


def test_a_box_that_is_refused_is_named_among_all(body):
    boxes = np.zeros((50_000, 2, 3))
    part = body.restrict_to(clsdf.Region((-1, -1, -1), (1, 1, 1), half_width=0.2))
    for wrong in (np.nan, 3.0):
        boxes[40_000] = wrong
        with pytest.raises(clsdf.Error, match="box 40000 "):
            part.classify(boxes, 0.1)


def test_winding_numbers_of_a_mesh_with_a_hole():
    vertices, faces = clsdf.make_shape("sphere3")
    with pytest.warns(clsdf.MeshWarning, match=r"3 open edges.*% of 1024 points"):
        body = clsdf.Transform((vertices, faces[1:]))
    assert body.sign == "solid-angle" and body.topology.tested_points == 1024
    points = np.array([[0, 0, 0], [0, 0, 3], [np.nan, 0, 0]])
    winding = body.winding(points)
    assert winding.dtype == np.float32 and 0.9 < winding[0] < 1 and abs(winding[1]) < 0.1 and np.isnan(winding[2])
    assert body.winding(points[0]) == winding[0]
    assert body.query(points[0]).distance < 0
    wide = np.empty(3)
    assert body.winding(points, out=wide) is wide and np.float32(wide[0]) == winding[0]


def test_a_lamp_on_a_body_is_counted_as_a_detail():
    unit = np.array([[v & 1, v >> 1 & 1, v >> 2] for v in range(8)], np.float64)
    body_faces = np.array([[0, 4, 6], [0, 6, 2], [1, 3, 7], [1, 7, 5], [0, 1, 5], [0, 5, 4], [2, 6, 7], [2, 7, 3],
                           [4, 5, 7], [4, 7, 6], [0, 2, 3], [0, 3, 1]])
    vertices = np.concatenate([unit * [8, 8, 4], unit * [1, 1, 2] + [1, 1, 4.1]])
    faces = np.concatenate([body_faces, body_faces[:10] + 8])  # open towards the body
    with pytest.warns(clsdf.MeshWarning, match=r"1 small open part is a detail of the body: close it.*10 faces"):
        body = clsdf.Transform(vertices, faces)
    assert body.sign == "solid-angle"
    for topology in (body.topology, pickle.loads(pickle.dumps(body.topology))):
        assert (topology.detail_parts, topology.detail_faces, topology.first_detail_face) == (1, 10, 12)


def test_a_terrain_has_a_sign_with_a_floor():
    vertices = np.array([[0, 0, 2], [4, 0, 2], [4, 4, 2], [0, 4, 2]], np.float64)
    faces = np.array([[0, 1, 2], [0, 2, 3]], np.int32)
    with pytest.warns(clsdf.MeshWarning, match="sign rule below with a floor"):
        assert clsdf.Transform((vertices, faces)).sign == "none"
    body = clsdf.Transform((vertices, faces), sign="below", floor=-1)
    rays = body.rays([[1, 2, 9], [1, 2, -9], [-3, 2, 0]], [[0, 0, -1], [0, 0, 1], [1, 0, 0]], most=2)
    assert np.array_equal(rays.t, [[7, 10], [8, 11], [3, 7]])
    none = clsdf.no_triangle  # of walls and floor
    assert np.array_equal(rays.triangle, [[1, none], [none, 1], [none, none]])
    links = body.links(clsdf.Grid((1, 2, -1.5), (1, 1, 1), (1, 1, 5)), [[0, 0, 1], [0, 0, -1]])
    assert np.array_equal(links.flags, [clsdf.Links.CLOSING, 0]) and np.array_equal(links.q, [0.5, 0.5])
    points = np.array([[2, 2, 1], [2, 2, 3], [5, 2, 1], [2, 2, -2.0]])
    for each in (body, pickle.loads(pickle.dumps(body))):
        assert each.sign == "below" and np.array_equal(each.query(points).distance < 0, [True, False, False, False])
    assert body.topology.rim_loops == 1 and body.topology.downward_faces == 0
    closed = clsdf.close_down((vertices, faces), -1)
    assert np.array_equal(closed.vertices[:4], vertices) and np.array_equal(closed.faces[:2], faces)
    assert np.array_equal(clsdf.Transform(closed).query(points).distance < 0, [True, False, False, False])
    with pytest.raises(clsdf.InvalidArgument, match="needs a floor"):
        clsdf.Transform((vertices, faces), sign="below")
    with pytest.raises(clsdf.Error, match="is no number"):
        clsdf.Transform((vertices, faces), sign="below", floor="deep")
    with pytest.raises(clsdf.InvalidMesh, match="look down"):
        clsdf.close_down((vertices, faces[:, ::-1]), -1)


def test_rays_meet_walls_and_faces():
    cube = np.array([[x, y, z] for z in (-1, 1) for y in (-1, 1) for x in (-1, 1)], float), [
        [0, 2, 3], [0, 3, 1], [4, 5, 7], [4, 7, 6], [0, 1, 5], [0, 5, 4],
        [2, 6, 7], [2, 7, 3], [0, 4, 6], [0, 6, 2], [1, 3, 7], [1, 7, 5]]
    body = clsdf.Transform(cube)
    # One origin serves all directions; they go through faces, an edge and a vertex.
    directions = np.array([[0, 0, 2], [4, 1, 0], [-1, 1, 0], [1, 1, 1], [0, -1, 0]], float)
    rays = body.rays((0, 0, 0), directions, counts=True)
    assert rays.t.dtype == np.float64 and rays.triangle.dtype == rays.counts.dtype == np.uint32
    assert np.array_equal(rays.t, [0.5, 0.25, 1, 1, 1]) and np.array_equal(rays.counts, [1] * 5)
    assert np.array_equal(body.rays(directions * [[[0]], [[3]]], -directions, hits="faces").t.shape, (2, 5))
    several = body.rays((-4, 0.25, 0.5), (2, 0, 0), most=3, dtype="float32")
    assert several.t.dtype == np.float32 and np.array_equal(several.t, [1.5, 2.5, np.inf])
    assert list(several.triangle) == [8, 11, clsdf.no_triangle] and several.counts is None
    one = body.rays((-4, 0.25, 0.5), (2, 0, 0), limit=1.4)
    assert one.t == np.inf and one.triangle == clsdf.no_triangle
    # From a wall outwards there is no wall; the face itself is met.
    assert body.rays((0, 0, 1), (0, 0, 1)).t == np.inf and body.rays((0, 0, 1), (0, 0, 1), hits="faces").t == 0
    assert np.array_equal(body.any_hit([[0, 0, -3], [0, 0, 3]], [[0, 0, 1], [0, 0, 1]], hits="faces"), [True, False])
    assert np.array_equal(body.visible([[0, 0, 0], [0, 0, 0], [0, 0, 1]], [[0, 0, 0.5], [0, 0, 3], [0, 0, 3]]),
                          [True, False, True])
    assert not body.visible((0, 0, 1), (0, 0, 3), hits="faces")
    single = body.rays(np.zeros((5, 3), np.float32), directions.astype(np.float32)[:, ::1])
    assert np.array_equal(single.t, rays.t)
    with pytest.warns(clsdf.MeshWarning, match="1 of 2 rays"):
        assert np.isnan(body.rays([[0, 0, np.nan], [0, 0, 0]], (0, 0, 1)).t[0])
    for wrong, message in [
        (dict(hits="walls of"), "neither 'walls' nor 'faces'"),
        (dict(limit=-1), "limit -1"),
        (dict(most=0), "most: 0"),
        (dict(dtype="int32"), "neither 'float32' nor 'float64'"),
    ]:
        with pytest.raises(clsdf.Error, match=message):
            body.rays((0, 0, 0), (0, 0, 1), **wrong)
    with pytest.raises(clsdf.Error, match=r"origins has the shape \(2, 3\) and directions \(4, 3\)"):
        body.rays(np.zeros((2, 3)), np.zeros((4, 3)))
    with pytest.raises(clsdf.Error, match=r"directions has the shape \(2,\)"):
        body.rays(np.zeros((2, 3)), np.zeros(2))
    sheet = clsdf.Transform((cube[0], cube[1][:2]), sign="none")
    with pytest.raises(clsdf.Error, match="no sign"):
        sheet.rays((0, 0, 0), (0, 0, 1))
    assert sheet.rays((0, 0, 0), (0, 0, -1), hits="faces").t == 1
    # Without its lid the cube has a film, which has no triangle.
    cup = clsdf.Transform((cube[0], cube[1][:2] + cube[1][4:]), sign="solid-angle").rays((0, 0, -9), (0, 0, 1), most=2)
    assert cup.t[0] == 8 and abs(cup.t[1] - 10) < 1e-7 and list(cup.triangle) == [0, clsdf.no_triangle]


def test_boxes_are_classified():
    # `within` counts from the boxes around triangles, so these are small.
    shape = clsdf.make_shape("sphere3")
    body, brute = clsdf.Transform(shape), BruteForce(*shape)
    random = np.random.default_rng(5)
    lower = random.uniform(-1.2, 1.2, (300, 3))
    boxes = np.stack([lower, lower + 0.02], 1)
    places = body.classify(boxes, 0.05)
    assert places.dtype == np.uint8 and set(places) == {0, 1, 2}
    distance = brute.distance(boxes.mean(1))
    assert (places[np.abs(distance) <= 0.05] == clsdf.BoxPlace.WITHIN).all()
    assert (distance[places == clsdf.BoxPlace.INSIDE] < -0.05).all()
    assert (distance[places == clsdf.BoxPlace.OUTSIDE] > 0.05).all()
    with pytest.raises(clsdf.Error, match="box 1"):
        body.classify([[[0, 0, 0], [1, 1, 1]], [[0, 0, 0], [-1, 1, 1]]], 0.1)


def test_a_part_of_the_domain_has_the_bytes_of_the_whole(body, points):
    region = clsdf.Region((0, -1, -1), (1.5, 1, 1), half_width=0.2, spacing=0.1)
    part = body.restrict_to(region)
    inside = points[(points[:, 0] > 0) & (np.abs(points[:, 1:]) < 1).all(1)]
    assert len(inside) > 50
    assert np.array_equal(part.query(inside, within=0.2).distance, body.query(inside, within=0.2).distance)
    with pytest.raises(clsdf.Error, match="region"):
        part.query([[-1, 0, 0]], within=0.2)
    with pytest.raises(clsdf.Error, match="has no mesh; ask the whole"):
        part.sample(3)


def test_a_part_with_a_margin_moves_as_the_whole(body, points):
    vertices, faces = clsdf.make_shape("sphere4")
    whole = clsdf.Transform((vertices, faces), device=body.device)
    part = whole.restrict_to(clsdf.Region((0.2, -0.5, -0.5), (1.2, 0.5, 0.5), half_width=0.2), margin=0.05)
    numbers = part.part_vertices
    assert numbers.dtype == np.uint32 and 0 < len(numbers) <= len(vertices) and (np.diff(numbers.astype(int)) > 0).all()
    inside = points[(points[:, 0] > 0.2) & (points[:, 0] < 1.2) & (np.abs(points[:, 1:]) < 0.5).all(1)]
    moved = vertices + np.random.default_rng(3).uniform(-0.028, 0.028, vertices.shape)
    whole.set_positions(moved)
    part.set_positions(moved[numbers])
    for own in (part, pickle.loads(pickle.dumps(part))):
        assert np.array_equal(own.query(inside, within=0.2).distance, whole.query(inside, within=0.2).distance)
        assert np.array_equal(own.box, whole.box) and np.array_equal(own.part_vertices, numbers)
    moved[numbers[7]] += 0.1
    with pytest.raises(clsdf.Error, match=f"vertex {numbers[7]} of .* the margin 0.05"):
        part.set_positions(moved[numbers])
    with pytest.raises(clsdf.Error, match="with a margin") as error:
        whole.part_vertices
    assert error.value.code == "unsupported"


def test_a_part_travels_as_bytes(body, points):
    part = body.restrict_to(clsdf.Region((0, -1, -1), (1.5, 1, 1), half_width=0.2, spacing=0.1))
    inside = points[(points[:, 0] > 0) & (np.abs(points[:, 1:]) < 1).all(1)]
    data = part.part_bytes()
    read = clsdf.Transform.from_part(data, body.device)
    expected = part.query(inside, within=0.2)
    for again in (read, copy.copy(read), pickle.loads(pickle.dumps(read))):
        assert np.array_equal(again.query(inside, within=0.2).distance, expected.distance)
        assert again.sign == part.sign and again.topology.closed and np.array_equal(again.box, body.box)
        assert again.part_bytes() == data
        assert np.array_equal(again.contains(inside), body.contains(inside))
    with pytest.raises(clsdf.Error, match="margin: 'wide' is no number"):
        body.restrict_to(clsdf.Region((0, -1, -1), (1.5, 1, 1), half_width=0.2, spacing=0.1), margin="wide")
    with pytest.raises(clsdf.Error, match="restrict it first") as error:
        body.part_bytes()
    assert error.value.code == "unsupported"
    with pytest.raises(clsdf.Error, match="were changed"):
        clsdf.Transform.from_part(data[:-1] + bytes([data[-1] ^ 1]))
    with pytest.raises(clsdf.Error, match="is no bytes"):
        clsdf.Transform.from_part(np.zeros(3))
    with pytest.raises(clsdf.Error, match="has no mesh"):
        read.vertices


def test_processes_share_a_transform(body, points, tmp_path):
    memory = shared_memory.SharedMemory(create=True, size=body.prepared_bytes)
    try:
        body.share(memory.buf)
        expected = body.query(points, outputs="gradient triangle")
        read = clsdf.Transform.from_shared(memory.buf.toreadonly(), body.device)
        found = read.query(points, outputs="gradient triangle")
        for output in ("distance", "gradient", "triangle"):
            assert np.array_equal(getattr(found, output), getattr(expected, output))
        assert np.array_equal(read.box, body.box) and read.sign == body.sign and read.topology.closed
        assert read.memory[0] < 0.1 * body.memory[0]
        with pytest.raises(BufferError):  # which the transform keeps open
            memory.close()
        program = (
            "import sys, numpy as np, clsdf\n"
            "from multiprocessing import resource_tracker, shared_memory\n"
            "memory = shared_memory.SharedMemory(sys.argv[1])\n"
            "resource_tracker.unregister(memory._name, 'shared_memory')  # which the other process removes\n"
            "body = clsdf.Transform.from_shared(memory.buf)\n"
            "np.save(sys.argv[3], body.query(np.load(sys.argv[2])).distance)\n"
            "del body\n"
        )
        np.save(tmp_path / "points.npy", points)
        subprocess.run(
            [sys.executable, "-c", program, memory.name, tmp_path / "points.npy", tmp_path / "found.npy"],
            check=True,
            cwd=tmp_path,
        )
        assert np.array_equal(np.load(tmp_path / "found.npy"), expected.distance)
        with pytest.raises(clsdf.Error, match="neither copied nor pickled") as error:
            pickle.dumps(read)
        assert error.value.code == "unsupported"
        with pytest.raises(clsdf.Error, match="made by from_shared.* has no mesh"):
            read.vertices
        del read, found, error  # whose traceback has the transform, too
    finally:
        memory.close()
        memory.unlink()
    with pytest.raises(clsdf.Error, match="nothing has been written"):
        clsdf.Transform.from_shared(mmap.mmap(-1, 1 << 12))
    with pytest.raises(clsdf.Error, match="no buffer in one piece"):
        clsdf.Transform.from_shared(3)
    with pytest.raises(clsdf.Error, match="the buffer is read-only"):
        body.share(bytes(body.prepared_bytes))
    with pytest.raises(clsdf.Error, match="as prepared_bytes"):
        body.share(mmap.mmap(-1, 1 << 12))


def test_what_a_transform_says_of_itself(body, solid):
    assert body.sign == "nonzero" and body.topology.closed and body.topology.open_edges == 0
    assert np.array_equal(body.box, [solid[0].min(0), solid[0].max(0)])
    assert body.memory[0] > 0
    assert repr(body) == f"<clsdf.Transform: mesh, sign nonzero, on {body.device.name}>"
    assert repr(body.topology) == "<clsdf.Topology: closed, balanced>"
    device = body.device.info()
    assert device.name == body.device.name and device.usable
    assert device.name in [known.name for known in clsdf.devices()]
    with pytest.raises(clsdf.Error) as error:
        clsdf.Transform(solid, device="no such device")
    assert error.value.code == "no_device"
    with pytest.raises(clsdf.Error) as error:
        clsdf.Device.select(-1)
    assert error.value.code == "no_device"
    if device.index is not None:
        assert clsdf.Device.select(device.index).name == clsdf.Device.select(str(device.index)).name == device.name
    with pytest.raises(clsdf.Error, match="device: 2.5 is no clsdf.Device"):
        clsdf.Transform(solid, device=2.5)
    with pytest.raises(clsdf.Error, match="auto, nonzero, parity, solid-angle, below, none"):
        clsdf.Transform(solid, sign="odd")


def test_a_limited_device(solid, points):
    device = clsdf.Device.automatic()
    if device.info().kind != "processor":
        pytest.skip("most GPUs cannot be divided")
    one = device.limited(compute_units=1)
    assert one.info().compute_units == 1
    assert np.array_equal(clsdf.Transform(solid, device=one).query(points).distance,
                          clsdf.Transform(solid).query(points).distance)


def test_without_a_band_every_sample_has_its_distance(body, solid):
    field = body.field(resolution=16, outputs="triangle")
    lower, upper = body.box
    longest = np.subtract(upper, lower).max()
    assert field.band.inside == field.band.outside == np.inf and (field.triangle != clsdf.no_triangle).all()
    assert np.min(lower - field.grid.origin) >= 0.0499 * longest and field.grid == body.grid(16)
    grid = field.grid
    blocks = body.blocks(grid, [(0, 0, 0)], grid.size)
    others = (body.fields([grid])[0], next(iter(body.slabs(grid))), blocks)
    assert all(np.array_equal(np.reshape(one.distance, grid.shape), field.distance) for one in others)
    scene = clsdf.Scene()
    scene.add(solid)
    assert scene.field(resolution=16).band.outside == pytest.approx(0.1 * longest)


def test_shares_of_a_machine(solid, points):
    whole = clsdf.Device.automatic().info()
    if whole.kind != "processor":
        pytest.skip("GPUs are dealt out")
    try:
        shares = [clsdf.Device.of_rank(rank, 3) for rank in range(3)]
    except clsdf.Error as error:
        assert error.code == "unsupported"
        pytest.skip(str(error))
    for share in shares:
        assert share.info().compute_units == max(1, whole.compute_units // 3)
    assert np.array_equal(clsdf.Transform(solid, device=shares[2]).query(points).distance,
                          clsdf.Transform(solid).query(points).distance)
    with pytest.raises(clsdf.Error) as refused:
        clsdf.Device.of_rank(3, 3)
    assert refused.value.code == "invalid_argument"


def test_a_band_below_one_voxel_is_told_once(body, solid):
    grid = clsdf.Grid((-1, -1, -1), 0.1, (24, 20, 16))
    calls = {
        "field": lambda band: body.field(grid, band=band),
        "fields": lambda band: body.fields([grid, clsdf.Grid((-1, -1, -1), 0.01, (4, 4, 4))], band=band),
        "slabs": lambda band: list(body.slabs(grid, band=band)),
    }
    for name, call in calls.items():
        for band, width in ((0.05, "0.5"), ((0.2, 0.07), "0.7"), ((0.08, 0), "0.8")):
            with pytest.warns(clsdf.MeshWarning, match=f"{width} voxels wide") as warned:
                call(band)
            assert len(warned) == 1 and warned[0].filename == __file__, name
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            for band in (0.1, "2v", 0, (0.2, 0), "full"):
                call(band)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        clsdf.Transform(solid, sign="none").field(grid, band=(0.05, 0.2))


def test_fields_and_slabs_may_be_positive_inside(body):
    grids = [body.grid(16), body.grid(20)]
    options = {"band": "3v", "outputs": "gradient", "positive_inside": True}
    for field, grid in zip(body.fields(grids, **options), grids):
        expected = body.field(grid, **options)
        assert field.positive_inside
        for name in expected.outputs:
            assert field[name].tobytes() == expected[name].tobytes()
    with pytest.raises(clsdf.Error, match="signs alone"):
        body.fields(grids, band=0, positive_inside=True)
