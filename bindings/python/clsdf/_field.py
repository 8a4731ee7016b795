"""A field: samples of the signed distance, and of all else that was asked for, on a grid."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING, Any, Literal, overload

import numpy as np
import numpy.typing as npt

from . import _interpolation
from ._core import Band, Grid
from ._images import Image
from ._meshes import Groups, Mesh
from ._values import Values
from .typing import ArrayLike

if TYPE_CHECKING:
    from ._transform import Transform


class Field(Values):
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
        super().__init__(arrays)
        self.grid = grid
        self.band = band
        self.sign = sign
        self.mesh_name = mesh_name
        self.positive_inside = positive_inside
        self.floor = floor
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
        from ._files import write_field

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
        values, gradients = _interpolation.interpolated(self, points, gradient)
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
        return _interpolation.surface_of(self, _interpolation.check_level(level), body)

    def _repr_png_(self) -> bytes | None:
        """A notebook shows the slice in the middle."""
        from ._pictures import slice_picture

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
