"""Files of fields."""

from __future__ import annotations

import pickle
import warnings
from types import SimpleNamespace

import numpy as np
import pytest

import clsdf


@pytest.mark.parametrize("ending", ["nrrd", "npy", "vti", "h5"])
def test_a_field_is_read_as_it_was_written(body, tmp_path, ending):
    field = body.field(resolution=16, band=("5%", "10%"), outputs="distance triangle site closest gradient barycentric offset")
    path = tmp_path / f"field.{ending}"
    clsdf.write_field(field, path)
    read = clsdf.read_field(str(path))
    assert read.grid == field.grid and read.band == field.band
    assert (read.sign, read.mesh_name, read.outputs) == (field.sign, field.mesh_name, field.outputs)
    for name in field.outputs:
        assert read.arrays[name].dtype == field.arrays[name].dtype
        assert np.array_equal(read.arrays[name], field.arrays[name], equal_nan=True), name
    distance = read.distance
    del read
    assert np.array_equal(distance, field.distance)


def test_npy_is_numpys(body, tmp_path):
    field = body.field(resolution=16)
    clsdf.write_field(field, tmp_path / "field.npy")
    assert np.array_equal(np.load(tmp_path / "field.npy"), field.distance)


def test_strided_arrays_and_other_types_are_written(body, tmp_path):
    grid = body.grid(12)
    out = {"distance": np.empty(grid.shape[::-1]).T, "triangle": np.empty(grid.shape, np.int32)}
    field = body.field(grid, out=out)
    clsdf.write_field(field, tmp_path / "field.nrrd")
    read = clsdf.read_field(tmp_path / "field.nrrd")
    plain = body.field(grid, outputs="triangle")
    assert np.allclose(read.distance, plain.distance, atol=1e-6) and np.array_equal(read.triangle, plain.triangle)


def test_slabs_make_the_file_of_the_whole(body, tmp_path):
    field = body.field(resolution=20, outputs="distance triangle")
    clsdf.write_field(field, tmp_path / "whole.vti")
    nx, ny, nz = field.grid.size
    with clsdf.FieldWriter(tmp_path / "slabs.vti", field.grid, field.band, field.sign, "mesh", field.outputs) as writer:
        for k in range(0, nz, 3):
            part = field.grid.part((0, 0, k), (nx, ny, min(3, nz - k)))
            writer.append(body.field(part, band=field.band, outputs="triangle"))
        assert not (tmp_path / "slabs.vti").exists()
    assert (tmp_path / "slabs.vti").read_bytes() == (tmp_path / "whole.vti").read_bytes()


def test_no_file_after_an_exception(body, tmp_path):
    field = body.field(resolution=8)
    with pytest.raises(ZeroDivisionError):
        with clsdf.FieldWriter(tmp_path / "field.nrrd", field.grid, field.band, field.sign) as writer:
            writer.append(field)
            1 / 0
    assert list(tmp_path.iterdir()) == []
    with pytest.raises(clsdf.Error, match="slices"):
        with clsdf.FieldWriter(tmp_path / "field.nrrd", field.grid, field.band, field.sign) as writer:
            pass
    assert list(tmp_path.iterdir()) == []


def test_files_that_cannot_be(body, tmp_path):
    field = body.field(resolution=8)
    for path, code in ((tmp_path / "field.xyz", "unsupported"), (tmp_path / "no" / "field.npy", "output_failure")):
        with pytest.raises(clsdf.Error) as error:
            clsdf.write_field(field, path)
        assert error.value.code == code
    with pytest.raises(clsdf.Error) as error:
        clsdf.read_field(tmp_path / "none.nrrd")
    assert error.value.code == "unreadable_input"


def test_files_state_the_floor_of_a_terrain(tmp_path):
    vertices = np.array([[0, 0, 2], [4, 0, 2], [4, 4, 2], [0, 4, 2]], np.float64)
    body = clsdf.Transform(vertices, np.array([[0, 1, 2], [0, 2, 3]]), sign="below", floor=-1)
    grid = body.grid(12)
    for each in (body, pickle.loads(pickle.dumps(body))):
        field = each.field(grid, band="full")
        assert field.floor == each.floor == -1
        for path in (tmp_path / "field.nrrd", tmp_path / "field.h5"):
            clsdf.write_field(field, path)
            assert clsdf.read_field(path).floor == -1
    into = clsdf.Transform(vertices, np.array([[0, 1, 2], [0, 2, 3]]), sign="none").field(grid, band="full")
    assert into.floor is None and body.field(out=into).floor == -1
    assert body.fields([grid], band="full")[0].floor == next(body.slabs(grid, band="full")).floor == -1
    path = tmp_path / "slabs.npy"
    with clsdf.FieldWriter(path, grid, "full", body.sign, floor=body.floor) as writer:
        for slab in body.slabs(grid, band="full"):
            writer.append(slab)
    assert clsdf.read_field(path).floor == -1
    with pytest.raises(clsdf.Error, match="sign rule below"):
        clsdf.FieldWriter(path, grid, "full", "nonzero", floor=-1)
    body.sparse(grid).write(tmp_path / "sparse.npy")
    body.write_sparse(tmp_path / "sparse.h5", grid)
    for path in (tmp_path / "sparse.npy", tmp_path / "sparse.h5"):
        assert clsdf.read_sparse_field(path).floor == clsdf.read_field(path).floor == -1


def test_what_sdf_does_not_record_is_told(body, tmp_path):
    path = tmp_path / "field.sdf"
    grid = body.grid(12)
    for options, match in (({"positive_inside": True}, "positive inside"), ({}, "does not state its band")):
        field = body.field(grid, band="3v", **options)
        with pytest.warns(clsdf.MeshWarning, match=match) as warned:
            clsdf.write_field(field, path)
        assert len(warned) == 1 and warned[0].filename == __file__ and path.exists()
    with pytest.warns(clsdf.MeshWarning, match="does not state its band") as warned:
        clsdf.FieldWriter(path, grid, "3v", body.sign)
    assert warned[0].filename == __file__
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        clsdf.write_field(body.field(grid, band="full"), path)
        clsdf.write_field(field, tmp_path / "field.nrrd")


def test_a_file_of_refined_levels_has_one_convention_and_no_image(body, tmp_path):
    grid = clsdf.Grid((-1, -1, -1), 0.5, (5, 5, 5))
    fields = [body.field(grid, band="full"), body.field(grid, band="full", positive_inside=True)]
    with pytest.raises(clsdf.Error, match="box 1 is positive inside, and box 0 is not"):
        clsdf.write_overlapping_amr(fields, tmp_path / "levels.vtkhdf")
    image = SimpleNamespace(GetOrigin=lambda: (-1,) * 3, GetSpacing=lambda: (0.5,) * 3, GetSize=lambda: (5,) * 3,
                            GetDirection=lambda: tuple(np.eye(3).ravel()))
    with pytest.raises(clsdf.Unsupported, match="box 0 is the field of an image"):
        clsdf.write_overlapping_amr([body.field(image=image, band="full")], tmp_path / "levels.vtkhdf")
    assert not list(tmp_path.iterdir())


def test_vtk_shows_refined_levels_where_they_are(body, tmp_path):
    vtk = pytest.importorskip("vtk")
    to_numpy = pytest.importorskip("vtk.util.numpy_support").vtk_to_numpy
    if not hasattr(vtk.vtkHDFReader, "SetMaximumLevelsToReadByDefaultForAMR"):
        pytest.skip("this VTK reads no refined levels")
    lower = np.array(body.bounds).reshape(2, 3)[0]
    side = float(np.ptp(np.array(body.bounds).reshape(2, 3), axis=0).max()) / 8
    coarse = clsdf.Grid(lower + side / 2, side, (8, 8, 8))
    # The finer cells lie in the coarse cells from (2, 4, 0) on.
    fine = clsdf.Grid(lower + side * np.array([2, 4, 0]) + side / 4, side / 2, (4, 6, 2))
    fields = body.fields([fine, coarse], band="100%", outputs="distance closest")
    path = tmp_path / "levels.vtkhdf"
    clsdf.write_overlapping_amr(fields, path)
    reader = vtk.vtkHDFReader()
    reader.SetFileName(str(path))
    reader.SetMaximumLevelsToReadByDefaultForAMR(0)
    reader.Update()
    levels = reader.GetOutputDataObject(0)
    assert levels.IsA("vtkOverlappingAMR") and levels.GetNumberOfLevels() == 2
    for level, field in enumerate(reversed(fields)):
        image = levels.GetDataSetAsImageData(level, 0)
        bounds = np.reshape(image.GetBounds(), (3, 2))
        first = np.array(field.grid.origin) - np.array(field.grid.spacing) / 2
        assert np.allclose(bounds[:, 0], first)
        assert np.allclose(bounds[:, 1], first + np.array(field.grid.spacing) * field.grid.size)
        for name in field.outputs:
            found = to_numpy(image.GetCellData().GetArray(name))
            assert np.array_equal(found.ravel(), field.arrays[name].ravel())
    hidden = to_numpy(levels.GetDataSetAsImageData(0, 0).GetCellData().GetArray("vtkGhostType"))
    assert np.count_nonzero(hidden) == 2 * 3 * 1
    with pytest.raises(clsdf.Error, match="box 0 of a refined mesh: .* is no whole part"):
        third = clsdf.Grid(lower + side / 2, side * 0.7, (2, 2, 2))
        clsdf.write_overlapping_amr([body.field(third, band="100%"), body.field(coarse, band="100%")], path)
