"""A field: samples of the signed distance, and of all else that was asked for, on a grid."""

from __future__ import annotations

from typing import Any

import numpy as np

from ._core import Band, Grid
from ._values import Values


class Field(Values):
    """Samples on a grid, negative inside. Arrays have the shape (nz, ny, nx), z first: f.distance[k, j, i] lies at
    f.grid.position(i, j, k). Vectors have one axis more, (nz, ny, nx, 3), and are in the order x, y, z.

    grid: a Grid. band: a Band, in the mesh's units. sign: the rule in use, 'nonzero', 'parity', 'solid-angle',
    'below' or 'none' ('auto' in a file of another program that does not say). mesh_name: of the mesh's file, else
    'mesh'. positive_inside: distances and gradients are negated, also zeros and what lies beyond the band. floor: of the
    rule 'below', its z; None without one, or if a file does not say.
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
    ) -> None:
        super().__init__(arrays)
        self.grid = grid
        self.band = band
        self.sign = sign
        self.mesh_name = mesh_name
        self.positive_inside = positive_inside
        self.floor = floor

    def __repr__(self) -> str:
        return f"<clsdf.Field: {', '.join(self.outputs)}, shape {self.grid.shape}, sign {self.sign}>"

    @property
    def shape(self) -> tuple[int, int, int]:
        """(nz, ny, nx), of the grid."""
        return self.grid.shape

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
