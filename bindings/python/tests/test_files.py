"""Files of fields."""

from __future__ import annotations

import warnings

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
