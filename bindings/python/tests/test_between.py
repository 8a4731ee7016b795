"""Fields as arrays, between their samples, and as surfaces; fields of images."""

from __future__ import annotations

import numpy as np
import pytest
from test_use import turned

import clsdf


def test_a_field_is_an_array_of_its_distances(body):
    field = body.field(resolution=12, outputs="gradient")
    assert np.asarray(field) is field.distance or np.shares_memory(np.asarray(field), field.distance)
    assert np.array_equal(np.asarray(field), field.distance) and np.asarray(field, np.float64).dtype == np.float64
    copied = np.array(field)
    assert np.array_equal(copied, field.distance) and not np.shares_memory(copied, field.distance)
    assert np.min(field) == field.distance.min()


def test_a_field_writes_itself(body, tmp_path):
    field = body.field(resolution=12)
    field.write(tmp_path / "a.npy")
    clsdf.write_field(field, tmp_path / "b.npy")
    assert (tmp_path / "a.npy").read_bytes() == (tmp_path / "b.npy").read_bytes()


def test_between_samples_the_error_is_bounded(body):
    grid = body.grid(20, spacing=None, band="full").block((2, -3, 1), (19, 22, 17))
    grid = clsdf.Grid(grid.origin, np.array(grid.spacing) * (1, 0.8, 1.3), grid.size, grid.first)
    field = body.field(grid, band="full", dtype="float64")
    lower, upper = np.array(grid.box)
    random = np.random.default_rng(2)
    points = random.uniform(lower, upper, (20_000, 3))
    values, gradients = field.sample(points, gradient=True)
    error = abs(values - body.query(points, dtype="float64").distance)
    diagonal = np.linalg.norm(grid.spacing)
    assert 0.02 * diagonal < error.max() <= 0.5 * diagonal and error.mean() < 0.02 * diagonal
    assert np.array_equal(field.sample(points), values)
    # Samples themselves, to the last one, and one point.
    assert np.allclose(field.sample(grid.positions()), field.distance, atol=1e-14)
    assert field.sample(points[0]) == values[0] and field.sample(points.reshape(100, 200, 3)).shape == (100, 200)
    # The gradient is that of the values.
    step = 1e-6
    inner = points[:50]
    for axis in range(3):
        ahead, behind = inner.copy(), inner.copy()
        ahead[:, axis] += step
        behind[:, axis] -= step
        slope = (field.sample(ahead) - field.sample(behind)) / (2 * step)
        assert np.isclose(slope, gradients[:50, axis], atol=1e-6).mean() > 0.95
    scipy = pytest.importorskip("scipy.interpolate")
    x, y, z = field.axes()
    other = scipy.RegularGridInterpolator((z, y, x), field.distance)
    assert np.allclose(other(points[:, ::-1]), values, atol=1e-13)


def test_outside_the_grid_there_is_nothing(body):
    field = body.field(resolution=12)
    lower, upper = np.array(field.grid.box)
    values, gradients = field.sample([upper + 0.01, lower - 0.01, (np.nan, 0, 0), upper, lower], gradient=True)
    assert np.isnan(values).tolist() == [True] * 3 + [False] * 2 == np.isnan(gradients).all(1).tolist()
    assert np.isnan(field.sample((9, 9, 9))) and field.sample([]).shape == (0,)
    flat = body.field(clsdf.Grid(lower, 0.1, (5, 1, 1)), band="full")
    assert np.isfinite(flat.sample(lower + (0.15, 0, 0))) and np.isnan(flat.sample(lower + (0.15, 0.01, 0)))


def test_a_surface_has_its_vertices_on_the_level(body, solid):
    pytest.importorskip("skimage")
    field = body.field(resolution=48, margin=0.3, band=(0.3, 0.3))
    for level in (0.0, 0.2, -0.05):
        rough, exact = field.surface(level), field.surface(level, body=body)
        assert isinstance(rough, clsdf.Mesh) and np.array_equal(rough.faces, exact.faces)
        assert abs(field.sample(rough.vertices) - level).max() < 1e-5
        off = abs(body.query(exact.vertices, dtype="float64").distance - level)
        # Beside the medial axis, which the inner surface crosses, a step may end nearer to another face.
        assert np.quantile(off, 0.95) < 1e-9 and off.max() < field.grid.voxel
        assert level < 0 or off.max() < 1e-9
        made = clsdf.Transform(exact)
        assert made.topology.closed and made.volume > 0
        assert (made.volume > body.volume) == (level > 0) or level == 0
    assert clsdf.Transform(field.surface(0, body)).volume == pytest.approx(body.volume, rel=0.02)
    turned_field = body.field(field.grid, band=(0.3, 0.3), positive_inside=True)
    outer = turned_field.surface(-0.2, body)
    assert abs(body.query(outer.vertices, dtype="float64").distance - 0.2).max() < 1e-9
    assert clsdf.Transform(outer).volume > body.volume
    for level, message in ((0.31, "not within the field's band"), ("0", "not a number"), (np.nan, "not a number")):
        with pytest.raises(clsdf.InvalidArgument, match=message):
            field.surface(level)
    with pytest.raises(clsdf.InvalidArgument, match="no two neighbours"):
        body.field(clsdf.Grid((5, 5, 5), 0.1, 4), band="full").surface()


def test_a_picture_has_axes_and_a_scale(body):
    pytest.importorskip("matplotlib")
    import matplotlib

    field = body.field(resolution=24)
    plain, drawn = (clsdf.slice_picture(field, "y", axes=axes) for axes in (False, True))
    assert drawn.pixels.shape[1] == 512 and drawn.pixels.shape[2] == 3 and drawn.pixels.dtype == np.uint8
    assert not np.array_equal(plain.pixels.shape, drawn.pixels.shape) and "pyplot" not in vars(matplotlib)
    assert np.array_equal(clsdf.slice_picture(field, "y").pixels, drawn.pixels)
    for other in (body.field(field.grid, band=0), body.field(field.grid, band="full", positive_inside=True)):
        assert clsdf.slice_picture(other, axes=True).png().startswith(b"\x89PNG")


class OfItk:
    """The geometry of an image of SimpleITK."""

    def __init__(self, origin, spacing, size, direction):
        self.GetOrigin, self.GetSpacing = (lambda: origin), (lambda: spacing)
        self.GetSize, self.GetDirection = (lambda: size), (lambda: tuple(np.ravel(direction)))


def voxels(image):
    """The position of each voxel, (nz, ny, nx, 3)."""
    k, j, i = np.indices(image.GetSize()[::-1])
    steps = np.stack([i, j, k], -1) * image.GetSpacing()
    return steps @ np.reshape(image.GetDirection(), (3, 3)).T + image.GetOrigin()


DIRECTIONS = {
    "oblique": turned(0.7, (1, 2, 3)),
    "mirrored": turned(0.4, (3, -1, 2)) @ np.diag([1.0, 1, -1]),
    "as NIfTI has it": np.diag([-1.0, -1, 1]),
    "rounded": np.round(turned(0.7, (1, 2, 3)), 6),
    "along the axes": np.eye(3),
}


@pytest.mark.parametrize("name", DIRECTIONS)
def test_a_field_of_an_image_has_its_voxels(solid, name):
    body = clsdf.Transform(solid)
    direction = DIRECTIONS[name]
    size, spacing = (22, 17, 14), (0.11, 0.13, 0.15)
    origin = np.array((0.3, -0.2, 0.1)) - direction @ (0.5 * np.array(size) * spacing)
    image = OfItk(tuple(origin), spacing, size, direction)
    at = voxels(image)
    field = body.field(image=image, band="full", outputs="gradient closest triangle offset", dtype="float64")
    expected = body.query(at, "gradient closest triangle offset", dtype="float64")
    tolerance = 2e-5 if name == "rounded" else 1e-6
    assert field.shape == (14, 17, 22) and abs(field.distance - expected.distance).max() < tolerance
    same = field.triangle == expected.triangle
    assert same.mean() > 0.99
    for vectors in ("gradient", "closest", "offset"):
        off = abs(field[vectors] - expected[vectors])[same].max(-1)
        assert np.mean(off < 10 * tolerance) > 0.99, vectors
    banded = body.field(image=image, band="10%")
    assert banded.band.outside == pytest.approx(0.1 * np.ptp(body.box, axis=0).max())
    near = abs(expected.distance) < banded.band.outside
    assert abs(banded.distance - expected.distance)[near].max() < max(tolerance, 1e-6)
    inner = (slice(1, -1),) * 3  # the last voxel may be rounded out of the grid
    assert np.allclose(field.sample(at[inner]), field.distance[inner], atol=tolerance)
    values, gradients = field.sample(at[5:7, 5:7, 5:7] + 1e-3, gradient=True)
    assert abs(np.linalg.norm(gradients, axis=-1) - 1).max() < 0.3
    if name != "rounded":
        pytest.importorskip("skimage")
        surface = field.surface(-0.02, body)
        assert 0.5 * body.volume < clsdf.Transform(surface).volume < body.volume
        assert np.quantile(abs(body.query(surface.vertices).distance + 0.02), 0.9) < 1e-5


def test_files_of_images_keep_origin_and_direction(solid, tmp_path):
    body = clsdf.Transform(solid)
    size, spacing, origin = (12, 10, 9), (0.2, 0.25, 0.3), (-1.0, 0.5, -0.7)
    sitk = pytest.importorskip("SimpleITK")
    image = sitk.Image(*size, sitk.sitkUInt8)
    image.SetOrigin(origin), image.SetSpacing(spacing), image.SetDirection(tuple(turned(0.7, (1, 2, 3)).ravel()))
    field = body.field(image=image, band="full")
    field.write(tmp_path / "x.nrrd")
    read = sitk.ReadImage(str(tmp_path / "x.nrrd"))
    assert np.allclose(read.GetOrigin(), origin) and np.allclose(read.GetSpacing(), spacing)
    assert np.allclose(read.GetDirection(), image.GetDirection()) and read.GetSize() == size
    assert np.array_equal(sitk.GetArrayFromImage(read), field.distance)
    nibabel = pytest.importorskip("nibabel")
    field.write(tmp_path / "x.nii.gz")
    again = sitk.ReadImage(str(tmp_path / "x.nii.gz"))  # in the same space as the image
    assert np.allclose(again.GetOrigin(), origin, atol=1e-6)
    assert np.allclose(again.GetDirection(), image.GetDirection(), atol=1e-6)
    assert np.array_equal(sitk.GetArrayFromImage(again), field.distance)
    loaded = nibabel.load(tmp_path / "x.nii.gz")
    # The same voxels, in nibabel's space.
    mirrored = clsdf.Transform(solid[0] * (-1, -1, 1), solid[1])
    other = mirrored.field(image=loaded, band="full")
    assert np.allclose(other.distance, field.distance, atol=1e-5)
    other.write(tmp_path / "y.nii")
    assert np.allclose(nibabel.load(tmp_path / "y.nii").affine, loaded.affine, atol=1e-6)
    assert not [path for path in tmp_path.iterdir() if path.name.startswith(".")]


def test_an_image_far_from_0_has_its_own_voxels():
    vertices, faces = clsdf.make_shape("sphere3")
    origin = np.array([-100.3, 57.7, 31.1])
    image = OfItk(tuple(origin), (0.21, 0.23, 0.27), (13, 11, 9), [[0.8, -0.6, 0], [0.6, 0.8, 0], [0, 0, 1]])
    field = clsdf.Transform(vertices + origin + (0.3, 0.9, 1), faces).field(image=image, band="full")
    assert np.allclose(field.sample(voxels(image)), field.distance, atol=1e-6)


def test_a_file_of_an_image_says_what_the_field_is(tmp_path):
    mesh = clsdf.make_shape("sphere3")
    body = clsdf.Transform(mesh)
    field = body.field(image=OfItk((-1, -1, -1), (0.25,) * 3, (9, 9, 9), np.eye(3)), band=0.5, positive_inside=True)
    field.write(tmp_path / "x.nrrd")
    read = clsdf.read_field(tmp_path / "x.nrrd")
    assert read.positive_inside and read.band == field.band and read.sign == "nonzero" and read.mesh_name == body.mesh_name
    assert np.array_equal(read.distance, field.distance)


def test_an_image_of_the_outer_surface():
    vertices, faces = clsdf.make_shape("sphere3")
    two = np.concatenate([vertices, vertices + (0.8, 0, 0)]), np.concatenate([faces, faces + len(vertices)])
    with pytest.warns(clsdf.MeshWarning):
        body = clsdf.Transform(two, surface="outer")
    image = OfItk((-1, -1, -1), (0.2,) * 3, (15, 11, 11), np.eye(3))
    found = body.field(image=image, band="full")
    union = clsdf.Transform(clsdf.outer(two).mesh)
    assert np.allclose(found.distance, union.query(voxels(image)).distance, atol=1e-5)


def test_what_is_no_image(body, tmp_path):
    image = OfItk((0, 0, 0), (1, 1, 1), (4, 4, 4), np.eye(3))
    for call, message in (
        (lambda: body.field(image=np.zeros((4, 4, 4))), "a numpy.ndarray is no image"),
        (lambda: body.field(out=body.field(image=image, band="full")), "out: a field of an image"),
        (lambda: body.field(image=image, resolution=8), "image= excludes"),
        (lambda: body.field(image=image, out=np.zeros((4, 4, 4))), "image= excludes"),
        (lambda: body.field(image=OfItk((0, 0, 0), (1, 1, 1), (4, 4, 4), [[1, 0.1, 0], [0, 1, 0], [0, 0, 1]])), "right angles"),
        (lambda: body.field(image=OfItk((0, 0), (1, 1), (4, 4), np.eye(2))), "2 dimensions"),
        (lambda: body.field(image=image, band="full").write(tmp_path / "x.vti"), "written as .nrrd, .nii or .nii.gz"),
        (lambda: body.field(image=image, band="full", outputs="site").write(tmp_path / "x.nrrd"), "the distance alone"),
    ):
        with pytest.raises(clsdf.Error, match=message):
            call()
    with pytest.raises(clsdf.OutputFailure, match="No such file"):
        body.field(image=image, band="full").write(tmp_path / "no" / "x.nrrd")
