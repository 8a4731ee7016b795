"""Sparse fields: what they have is what a dense field has."""

from __future__ import annotations

import copy
import pickle
import warnings

import numpy as np
import pytest

import clsdf

OUTPUTS = "distance triangle site closest gradient barycentric offset"


def bits(array):
    return np.ascontiguousarray(array).view(np.uint8)


@pytest.fixture(scope="module")
def grid(body):
    """Not on multiples of 8."""
    around = body.grid(100, band="3v")
    h = np.array(around.spacing)
    return clsdf.Grid(np.array(around.origin) + h * (5, -3, 0), h, around.size, first=(-5, 3, 0))


def all_samples(grid):
    k, j, i = np.meshgrid(*(first + np.arange(n) for first, n in zip(grid.first[::-1], grid.size[::-1])), indexing="ij")
    return np.stack([i, j, k], -1)


def test_bricks_and_the_rest_are_the_dense_field(body, grid):
    sparse = body.sparse(grid, outputs=OUTPUTS)
    whole = grid.in_whole_bricks()
    assert whole.first == (-8, 0, 0) and all(n % 8 == 0 for n in whole.size)
    dense = body.field(whole, band=sparse.band, outputs=OUTPUTS)
    assert sparse.outputs == dense.outputs and sparse.grid == grid and sparse.sign == body.sign
    assert 10 < len(sparse) < np.prod(whole.size) // 512 // 2
    assert sparse.bricks.dtype == np.int64 and (sparse.bricks % 8 == 0).all()
    assert np.array_equal(sparse.bricks, sparse.bricks[np.lexsort(sparse.bricks.T)])
    corners = sparse.bricks - whole.first
    for name, values in sparse.arrays.items():
        expected = np.stack([dense.arrays[name][k : k + 8, j : j + 8, i : i + 8] for i, j, k in corners])
        assert values.shape == expected.shape and values.dtype == expected.dtype, name
        assert np.array_equal(bits(values), bits(expected)), name
    samples = all_samples(whole)
    assert np.array_equal(bits(sparse.distance_at(samples)), bits(dense.distance))
    number = sparse.find(samples)
    far = number < 0
    assert number.shape == whole.shape and (number.max(), number.min()) == (len(sparse) - 1, -1)
    assert (dense.triangle[far] == clsdf.no_triangle).all()
    # Runs: all bricks inside, and no others.
    inside = np.zeros(whole.shape, bool)
    for i, j, k, count in sparse.inside - np.array([*whole.first, 0]):
        inside[k : k + 8, j : j + 8, i : i + 8 * count] = True
    assert np.array_equal(inside, far & (dense.distance < 0)) and inside.any()


def test_one_sample_is_a_number(body, grid):
    sparse = body.sparse(grid)
    i, j, k = sparse.bricks[3]
    assert sparse.find((i + 7, j, k)) == 3
    assert sparse.distance_at((i + 7, j + 1, k + 2)) == sparse.distance[3, 2, 1, 7]
    assert sparse.distance_at([]).shape == (0,) and sparse.find(np.empty((0, 3), int)).shape == (0,)
    assert sparse.distance_at(np.array([[i, j, k]], np.uint32)).dtype == np.float32


@pytest.mark.parametrize("samples, match", [
    ((0.0, 1.0, 2.0), "whole numbers"),
    ((1, 2), "whole numbers"),
    ([[0, 0, 0], [0, 0, 4000]], r"\(0, 0, 4000\) is not in the bricks"),
    ((-9, 3, 0), r"from \(-8, 0, 0\) on"),
])
def test_samples_that_are_none(body, grid, samples, match):
    with pytest.raises(clsdf.InvalidArgument, match=match):
        body.sparse(grid).distance_at(samples)


def test_positive_inside_negates_all(body, grid):
    usual, turned = body.sparse(grid, outputs="gradient"), body.sparse(grid, outputs="gradient", positive_inside=True)
    samples = all_samples(grid)
    assert np.array_equal(turned.distance, -usual.distance)
    assert np.array_equal(turned.gradient, -usual.gradient, equal_nan=True)
    assert np.array_equal(turned.distance_at(samples), -usual.distance_at(samples))
    assert turned.positive_inside and not usual.positive_inside


def test_many_grids_have_the_fields_of_calls_of_their_own(body, grid):
    grids = [grid.part((i, 3, i), (20, 9, 17)) for i in (0, 5, 20)] + [body.grid(33)]
    fields = body.sparse_fields(grids, band="3v", outputs="triangle")
    assert len(fields) == 4
    for one, field in zip(grids, fields):
        alone = body.sparse(one, band="3v", outputs="triangle")
        assert field.grid == one and field.band == alone.band
        for a, b in ((field.bricks, alone.bricks), (field.inside, alone.inside), (field.distance, alone.distance),
                     (field.triangle, alone.triangle)):
            assert np.array_equal(bits(a), bits(b))
    assert body.sparse_fields([]) == []
    with pytest.raises(clsdf.Error, match="sparse\\(\\) for one"):
        body.sparse_fields(grid)


def test_a_grid_without_bricks(body):
    far = clsdf.Grid((50, 50, 50), 0.1, 20)
    sparse = body.sparse(far, outputs="closest")
    assert len(sparse) == 0 and sparse.bricks.shape == (0, 3) and sparse.inside.shape == (0, 4)
    assert sparse.distance.shape == (0, 8, 8, 8) and sparse.closest.shape == (0, 8, 8, 8, 3)
    assert sparse.distance_at((3, 4, 5)) == np.float32(sparse.band.outside)


def test_a_file_is_that_of_the_dense_field(body, grid, tmp_path):
    sparse = body.sparse(grid)
    sparse.write(tmp_path / "sparse.nvdb")
    clsdf.write_field(body.field(grid, band=sparse.band), tmp_path / "dense.nvdb")
    body.write_sparse(tmp_path / "layers.nvdb", grid)
    expected = (tmp_path / "dense.nvdb").read_bytes()
    assert (tmp_path / "sparse.nvdb").read_bytes() == expected
    assert (tmp_path / "layers.nvdb").read_bytes() == expected
    read = clsdf.read_field(tmp_path / "sparse.nvdb")
    assert np.array_equal(read.distance, sparse.distance_at(all_samples(grid)))
    with pytest.raises(clsdf.Error, match="negative inside"):
        body.sparse(grid, positive_inside=True).write(tmp_path / "turned.nvdb")


@pytest.mark.parametrize("ending", ["npy", "h5"])
def test_a_file_of_arrays_has_the_field(body, grid, tmp_path, ending):
    sparse = body.sparse(grid, outputs=OUTPUTS)
    sparse.write(tmp_path / f"sparse.{ending}")
    (tmp_path / "layers").mkdir()
    body.write_sparse(tmp_path / "layers" / f"sparse.{ending}", grid, outputs=OUTPUTS)
    files = sorted(path.name for path in tmp_path.glob("sparse*"))
    assert files == sorted(path.name for path in (tmp_path / "layers").iterdir())
    for name in files:
        assert (tmp_path / name).read_bytes() == (tmp_path / "layers" / name).read_bytes(), name
    read = clsdf.read_sparse_field(tmp_path / f"sparse.{ending}")
    assert read.grid == grid and read.band == sparse.band and read.outputs == sparse.outputs
    assert (read.sign, read.mesh_name, read.positive_inside) == (sparse.sign, sparse.mesh_name, False)
    assert np.array_equal(read.bricks, sparse.bricks) and np.array_equal(read.inside, sparse.inside)
    for name in sparse.outputs:
        assert np.array_equal(bits(read.arrays[name]), bits(sparse.arrays[name])), name
    dense = clsdf.read_field(tmp_path / f"sparse.{ending}")
    assert np.array_equal(bits(dense.distance), bits(body.field(grid, band=sparse.band).distance))


def test_a_sparse_field_is_read_of_sparse_files_alone(body, grid, tmp_path):
    clsdf.write_field(body.field(grid, band="3v"), tmp_path / "dense.npy")
    assert clsdf.read_sparse_field(tmp_path / "dense.npy") is None
    turned = body.sparse(grid, positive_inside=True)
    turned.write(tmp_path / "turned.npy")
    read = clsdf.read_sparse_field(tmp_path / "turned.npy")
    assert read.positive_inside and np.array_equal(read.distance, turned.distance)
    empty = body.sparse(clsdf.Grid((50, 50, 50), 0.1, 20))
    empty.write(tmp_path / "empty.h5")
    read = clsdf.read_sparse_field(tmp_path / "empty.h5")
    assert len(read) == 0 and read.distance.shape == (0, 8, 8, 8) and read.inside.shape == (0, 4)
    body.sparse(grid).write(tmp_path / "tree.nvdb")
    tree = clsdf.read_sparse_field(tmp_path / "tree.nvdb")
    samples = all_samples(grid)
    assert np.array_equal(tree.distance_at(samples), body.sparse(grid).distance_at(samples))
    with pytest.raises(clsdf.UnreadableInput, match="missing.npy"):
        clsdf.read_sparse_field(tmp_path / "missing.npy")


def test_values_that_were_changed_are_written(body, grid, tmp_path):
    sparse = body.sparse(grid)
    sparse.distance[:] = np.clip(sparse.distance, -0.01, 0.01)
    sparse.write(tmp_path / "clipped.nvdb")
    assert abs(clsdf.read_field(tmp_path / "clipped.nvdb").distance[
        tuple((sparse.bricks[0] - grid.first + 7)[::-1])]) <= np.float32(0.01)


def test_a_file_of_openvdb(body, grid, tmp_path):
    try:
        clsdf._core.check_field_path(str(tmp_path / "field.vdb"))
    except clsdf.Error as error:
        pytest.skip(str(error))
    body.sparse(grid).write(tmp_path / "sparse.vdb")
    read = clsdf.read_field(tmp_path / "sparse.vdb")
    assert np.array_equal(read.distance, body.field(grid, band="3v").distance)


def test_files_that_cannot_be(body, grid, tmp_path):
    for write in (body.sparse(grid).write, lambda path: body.write_sparse(path, grid)):
        for name, code in (("field.nrrd", "unsupported"), ("field.xyz", "unsupported"), ("no/field.nvdb", "output_failure")):
            with pytest.raises(clsdf.Error) as error:
                write(tmp_path / name)
            assert error.value.code == code
    assert list(tmp_path.iterdir()) == []


def test_what_is_for_dense_fields_is_refused(body, grid):
    for band, match in (("full", "band with an end"), (0, "signs alone")):
        with pytest.raises(clsdf.InvalidArgument, match=match):
            body.sparse(grid, band=band)
    with pytest.raises(clsdf.Error, match="excludes resolution"):
        body.sparse(grid, resolution=20)
    with pytest.raises(AttributeError, match="distance gradient"):
        body.sparse(grid).gradient


def test_a_body_without_a_sign(solid):
    open_body = clsdf.Transform(solid, sign="none")
    sparse = open_body.sparse(resolution=40)
    assert len(sparse.inside) == 0 and (sparse.distance >= 0).all() and sparse.sign == "none"
    with pytest.raises(clsdf.Error, match="nothing is inside"):
        open_body.sparse(resolution=40, positive_inside=True)


def test_a_part_of_the_domain(body, grid):
    part = grid.part((10, 10, 10), (20, 20, 20))
    lower, upper = part.in_whole_bricks().box
    band = body.sparse(part).band
    own = body.restrict_to(clsdf.Region(lower, upper, band.outside, grid.voxel))
    assert np.array_equal(own.sparse(part, band=band).distance, body.sparse(part, band=band).distance)


def test_progress_ctrl_c_and_warnings(body, grid):
    seen = []
    body.sparse(grid, progress=lambda stage, fraction: seen.append((stage, fraction)))
    assert seen[-1] == ("computing", 1.0)

    def stop(stage, fraction):
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        body.sparse(grid, progress=stop)
    with pytest.warns(clsdf.MeshWarning, match="voxels wide") as warned:
        body.sparse(grid, band="0.5v")
    assert warned[0].filename == __file__
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        body.sparse(grid)


def test_a_field_outlives_its_body_and_is_copied(solid):
    sparse = clsdf.Transform(solid).sparse(resolution=40)
    for other in (copy.deepcopy(sparse), pickle.loads(pickle.dumps(sparse))):
        assert np.array_equal(other.distance, sparse.distance) and other.grid == sparse.grid
        assert other.distance_at(sparse.bricks[0]) == sparse.distance[0, 0, 0, 0]
    assert "bricks of grid" in repr(sparse)
