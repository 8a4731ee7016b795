"""A field: samples of the signed distance, and of all else that was asked for, on a grid; its files (docs/formats.md) and
its pictures."""

from __future__ import annotations

import math
import os
import warnings
from collections.abc import Iterable
from types import TracebackType
from typing import TYPE_CHECKING, Any, Literal, overload

import numpy as np
import numpy.typing as npt

from . import _core, _images, _interpolation, _pictures
from ._core import Band, Grid
from ._error import Error, MeshWarning
from ._images import Image
from ._lengths import BandLike, band_without_mesh
from ._meshes import Groups, Mesh
from ._pictures import Picture
from ._values import Outputs, Samples, type_of, wanted
from .typing import ArrayLike

if TYPE_CHECKING:
    from ._transform import Transform


class Field(Samples):
    """Samples on a grid, negative inside. Arrays have the shape (nz, ny, nx), z first: f.distance[k, j, i] lies at
    f.grid.position(i, j, k). Vectors have one axis more, (nz, ny, nx, 3), and are in the order x, y, z.

    grid: a Grid. band: a Band, in the mesh's units. sign: the rule in use, 'nonzero', 'parity', 'solid-angle',
    'below' or 'none' ('auto' in a file of another program that does not say). mesh_name: of the mesh's file, else
    'mesh'. positive_inside: distances and gradients are negated, also zeros and what lies beyond the band. floor: of the
    rule 'below', its z; None without one, or if a file does not say. image: the geometry of the image that the grid is
    that of (origin, spacing, size, direction), or None; `grid` is in the image's frame then, all positions and vectors are
    in its space.
    """

    def __init__(
        self,
        grid: Grid,
        band: Band,
        sign: str,
        mesh_name: str,
        arrays: dict[str, Any],
        positive_inside: bool = False,
        floor: float | None = None,
        image: Image | None = None,
    ) -> None:
        super().__init__(grid, band, sign, mesh_name, arrays, positive_inside, floor)
        self.image = image

    def __repr__(self) -> str:
        return f"<clsdf.Field: {', '.join(self.outputs)}, shape {self.grid.shape}, sign {self.sign}>"

    @property
    def shape(self) -> tuple[int, int, int]:
        """(nz, ny, nx), of the grid."""
        return self.grid.shape

    def __array__(self, dtype: npt.DTypeLike | None = None, copy: bool | None = None) -> np.ndarray[Any, Any]:
        """numpy.asarray(field) is field.distance."""
        distance = _interpolation.distance_of(self)
        if dtype is not None and distance.dtype != np.dtype(dtype):
            if copy is False:
                raise ValueError(f"an array of {distance.dtype} is no array of {np.dtype(dtype)} without a copy")
            return distance.astype(dtype)
        return distance.copy() if copy else distance

    def write(self, path: str | os.PathLike[str], groups: Groups | None = None) -> None:
        """Writes a .nrrd, .npy, .vti, .h5, .nvdb or .sdf, and of an image .nrrd, .nii or .nii.gz (by nibabel):
        clsdf.write_field(field, path, groups)."""
        write_field(self, path, groups)

    @overload
    def sample(self, points: ArrayLike, gradient: Literal[False] = False) -> npt.NDArray[np.float64]: ...
    @overload
    def sample(
        self, points: ArrayLike, gradient: Literal[True]
    ) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]]: ...
    def sample(self, points: ArrayLike, gradient: bool = False) -> Any:
        """The distance between the samples, linear along each axis, at points (n, 3) or (..., 3): an array (...), float64;
        of one point (3,) a number. With `gradient` a tuple of it and its gradient (..., 3), which jumps between voxels.
        Points outside the grid (`grid.box`) have NaN.

        In a voxel whose 8 samples are within the band, the error is at most half its diagonal: 0.5 * sqrt(dx^2 + dy^2 +
        dz^2). Where the nearest surface is smooth, with curvatures of at most k at the offset of the point, it is at most
        k / 8 * (dx^2 + dy^2 + dz^2). body.query(points) has no error. Beyond the band the half width is interpolated.
        """
        values, gradients = _interpolation.interpolated(self, self.image, points, gradient)
        return (values, gradients) if gradient else values

    def surface(self, level: float = 0.0, body: Transform | None = None) -> Mesh:
        """The surface on which the field is `level`, as a mesh whose faces are counter-clockwise seen from outside: by marching
        cubes of scikit-image, which must be installed. level: in the mesh's units, within the band.

        The vertices lie on edges of the grid, where the linear distance is `level`; sample() has its error. With body, the
        transform that the field was made of, they are moved along the gradient by one query: onto the surface itself for
        the level 0, else to where the distance is `level`, unless another part of the surface is nearer there. The surface
        is open where it leaves the grid. Raises clsdf.Error (invalid_argument) if the level is not within the band, or
        between no two samples.
        """
        level = _interpolation.check_level(level)
        vertices, faces = _interpolation.surface_of(self, self.image, level)
        if body is not None:
            vertices = _moved_onto(body, -level if self.positive_inside else level, vertices)
        return Mesh(vertices, faces, name=self.mesh_name)

    def _repr_png_(self) -> bytes | None:
        """A notebook shows the slice in the middle."""
        return slice_picture(self).png() if isinstance(self.arrays["distance"], np.ndarray) else None

    def axes(self) -> tuple[np.ndarray[Any, Any], np.ndarray[Any, Any], np.ndarray[Any, Any]]:
        """The coordinates of the samples along x, y and z: float64 arrays (nx,), (ny,), (nz,)."""
        x, y, z = (
            origin + spacing * (first + np.arange(size))
            for origin, spacing, first, size in zip(
                self.grid.origin, self.grid.spacing, self.grid.first, self.grid.size
            )
        )
        return x, y, z

    def to_pyvista(self) -> Any:
        """A pyvista.ImageData with the outputs as arrays of its points. The arrays are not copied. Needs pyvista."""
        import pyvista  # type: ignore[import-not-found,import-untyped,unused-ignore]

        image = pyvista.ImageData(
            dimensions=self.grid.size, spacing=self.grid.spacing, origin=self.grid.position(0, 0, 0)
        )
        if self.image is not None:
            image.origin, image.direction_matrix = self.image.origin, self.image.direction
        samples = int(np.prod(self.grid.shape, dtype=np.int64))
        for name, array in self.arrays.items():
            image.point_data[name] = array.reshape(samples, -1) if array.ndim > 3 else array.reshape(samples)
        image.point_data.active_scalars_name = "distance"
        return image

    def to_xarray(self) -> Any:
        """An xarray.Dataset with the dimensions z, y, x (and `component` of vectors) and their coordinates. The arrays
        are not copied. Needs xarray."""
        import xarray  # type: ignore[import-not-found,import-untyped,unused-ignore]

        x, y, z = self.axes()
        data = {}
        for name, array in self.arrays.items():
            # Vectors of different lengths have different dimensions.
            dimensions = ("z", "y", "x") if array.ndim == 3 else ("z", "y", "x", f"component{array.shape[3]}")
            data[name] = (dimensions, array)
        attributes: dict[str, Any] = {"sign": self.sign, "band_inside": self.band.inside, "band_outside": self.band.outside}
        if self.band.exact_signs:
            attributes["exact_signs"] = 1
        if self.positive_inside:
            attributes["inside"] = "positive"
        if self.floor is not None:
            attributes["floor"] = self.floor
        return xarray.Dataset(data, coords={"z": z, "y": y, "x": x}, attrs=attributes)


def _moved_onto(body: Transform, level: float, vertices: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
    """Vertices where the distance to the body is `level`, along their gradients."""
    found = body.query(vertices, "closest gradient", dtype="float64")
    if level == 0:
        return np.asarray(found.closest, np.float64)
    if body.sign == "none" and level < 0:
        raise Error("level: a body without a sign has no negative distances")
    return vertices + (level - found.distance.astype(np.float64))[:, None] * found.gradient


def slice_picture(
    field: Field, axis: str = "z", index: int | None = None, pixels: int = 512, axes: bool | None = None
) -> Picture:
    """A slice of a field: blue inside, orange outside, paler near the surface, the surface black.

    axis: 'x', 'y' or 'z', to which the slice is perpendicular. index: of the slice; None: the middle. pixels: on the
    longer side, at most. axes: with coordinates, a colour bar and a title, by matplotlib; None: if it is installed.
    Without them a sample is a square of whole pixels. The first of the other two axes points to the right, the second
    one up. Raises clsdf.Error: invalid_argument for another axis or no such slice.
    """
    if not isinstance(field, Field):
        raise Error(f"field: {repr(field)[:100]} is no clsdf.Field; body.field() and read_field() make them")
    return _pictures.of_slice(field, field.axes(), axis, index, pixels, axes)


def read_field(path: str | os.PathLike[str]) -> Field:
    """Reads a field by the file's ending, also one of another program. A band that the file does not state has no end;
    a sign rule that it does not state is 'auto'. Raises clsdf.Error: unreadable_input names the file and the value;
    unsupported for an unknown ending."""
    return Field(*_core.read_field(os.fsdecode(path)))


def write_field(field: Field, path: str | os.PathLike[str], groups: Groups | None = None) -> None:
    """Writes a field by the file's ending; complete or not at all. A field of an image is written as .nrrd, .nii or
    .nii.gz (by nibabel), with the image's origin and direction, and the distance alone. groups: of the mesh; a .vti or
    .vtkhdf gets the group of each sample beside its triangle. A MeshWarning says what .sdf does not record: the
    band, and that the inside is positive. Raises clsdf.Error: output_failure; unsupported for an unknown ending, or
    outputs that the format cannot store."""
    if not isinstance(field, Field):
        raise Error(f"field: {_short(field)} is no clsdf.Field; body.field() and read_field() make them")
    if field.image is not None:
        _images.write(field, field.image, os.fsdecode(path))
        return
    writer = FieldWriter.__new__(FieldWriter)
    writer._open(path, field, field.outputs, groups)
    with writer:
        writer.append(field)


def write_overlapping_amr(fields: Iterable[Field], path: str | os.PathLike[str]) -> None:
    """Writes fields on boxes of refined levels as VTK's OverlappingAMR (.vtkhdf): their samples are centres of cells,
    and ParaView and VTK show coarse cells where no finer box covers them (VTK 9.7 does, 9.1 cannot read it). Fields of
    one spacing are a level, in any order, and do not overlap. Complete or not at all.

        clsdf.write_overlapping_amr([body.field(coarse, band=band), *body.fields(boxes, band=band)], "levels.vtkhdf")

    Raises clsdf.Error: invalid_argument names the box whose spacing or place does not fit the coarser level, or that
    has other outputs or another sign convention than the first; unsupported for another ending or the field of an image; output_failure."""
    fields = list(fields)
    for i, one in enumerate(fields):
        if one.image is not None:
            raise Error(f"box {i} is the field of an image, whose place and direction this format does not have", "unsupported")
        if one.positive_inside != fields[0].positive_inside:
            raise Error(f"box {i} is {'positive' if one.positive_inside else 'negative'} inside, and box 0 is not: the file "
                        "has one convention, which it does not state")
    boxes = [(f.grid, {name: _packed(name, f.arrays[name]) for name in f.outputs}) for f in fields]
    _core.write_overlapping_amr(os.fsdecode(path), boxes)


class FieldWriter:
    """Writes a field slab by slab, so that it need never be whole in memory. Use it in `with`: the file appears at the
    end, and does not if there was an exception. floor: of the sign rule 'below', its z (body.floor), which the file
    states. Raises as write_field() does.

        with clsdf.FieldWriter(path, grid, band, body.sign) as writer:
            for slab in body.slabs(grid, band=band):
                writer.append(slab)
    """

    def __init__(
        self,
        path: str | os.PathLike[str],
        grid: Grid,
        band: BandLike,
        sign: str,
        mesh_name: str = "mesh",
        outputs: Outputs = "distance",
        positive_inside: bool = False,
        groups: Groups | None = None,
        floor: float | None = None,
    ) -> None:
        if not isinstance(grid, Grid):
            raise Error(f"grid: {_short(grid)} is no clsdf.Grid")
        if not isinstance(band, Band):
            band = band_without_mesh(band, grid)
        self._open(path, Samples(grid, band, sign, mesh_name, {}, positive_inside, floor), wanted(outputs), groups)

    def _open(
        self, path: str | os.PathLike[str], field: Samples, outputs: tuple[str, ...], groups: Groups | None
    ) -> None:
        """field: all but its arrays."""
        if groups is not None and not isinstance(groups, Groups):
            raise Error(f"groups: {repr(groups)[:100]} is no clsdf.Groups; read_mesh(path).groups is one")
        names: list[str] = [] if groups is None else groups.names
        numbers = None if groups is None else np.ascontiguousarray(groups.numbers, np.int32)
        name = os.fsdecode(path)
        self._path = name
        self._writer: _core.Writer | None = _core.writer(
            name, field.grid, field.band, field.sign, field.mesh_name, outputs, field.positive_inside, names, numbers, field.floor
        )
        has_end = not math.isinf(max(field.band.inside, field.band.outside))
        if name.lower().endswith(".sdf") and (field.positive_inside or has_end):
            warnings.warn(
                f"{name} does not state that it is positive inside: tell it to those who read it, or use another format"
                if field.positive_inside
                else f"{name} does not state its band: programs that read it take the band's limit for the distance of "
                "samples beyond it; use band='full', or another format",
                MeshWarning,
                stacklevel=3,
            )

    def __repr__(self) -> str:
        return f"<clsdf.FieldWriter: {self._path}{'' if self._writer else ', finished'}>"

    def append(self, slab: Field) -> None:
        """The next whole slices, in ascending z, with the announced outputs."""
        if self._writer is None:
            raise Error("the file is finished")
        if not isinstance(slab, Field):
            raise Error(f"slab: {_short(slab)} is no clsdf.Field; body.slabs() and body.field() make them")
        self._writer.append({name: _packed(name, slab.arrays[name]) for name in slab.outputs})

    def finish(self) -> None:
        """Gives the file its name."""
        if self._writer is not None:
            self._writer.finish()
            self._writer = None

    def __enter__(self) -> FieldWriter:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if kind is None:
            self.finish()
        self._writer = None


def _short(value: Any) -> str:
    return f"{repr(value)[:100]}, a {type(value).__name__},"


def _packed(name: str, array: Any) -> Any:
    # Files have the types of the table; an int32 triangle of -1 is its no_triangle.
    dtype = type_of(name)[0]
    if array.dtype == np.int32 and dtype == np.uint32:
        array = array.view(np.uint32)
    return np.ascontiguousarray(array, dtype)
