"""Parts of the cells of a grid that a mesh fills."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from . import _core
from ._core import Grid
from ._meshes import arrays_of


class Fractions(NamedTuple):
    """The cells that the surface meets, a row each, by z, then y, then x. A cell lies between neighbouring samples of the
    grid. The solid is what the mesh encloses."""

    cells: npt.NDArray[np.int32]  #: (n, 3), on the lattice: the sample at the low corner
    pieces: npt.NDArray[np.uint32]  #: (n,) parts of the surface in the cell
    volume: npt.NDArray[np.float64]  #: (n,) of the solid, as a fraction of the cell
    centroid: npt.NDArray[np.float64]  #: (n, 3) of the solid, in cells from the middle of the cell
    area: npt.NDArray[np.float64]  #: (n,) of the surface, in squared units of the mesh
    vector_area: npt.NDArray[np.float64]  #: (n, 3) the integral of the outward normal, in squared units
    surface_centroid: npt.NDArray[np.float64]  #: (n, 3) in cells from the middle of the cell
    face_fractions: npt.NDArray[np.float64]  #: (n, 6) of the solid in the low and high face across x, y and z
    face_centroids: npt.NDArray[np.float64]  #: (n, 6, 2) of the solid there, along the two other axes
    full: npt.NDArray[np.bool_]  #: (nz - 1, ny - 1, nx - 1): the other cells that are wholly solid
    grid: Grid

    def dense(self) -> npt.NDArray[np.float64]:
        """The volume fractions of all cells, (nz - 1, ny - 1, nx - 1)."""
        field = self.full.astype(np.float64)
        x, y, z = (self.cells - np.array(self.grid.first)).T
        field[z, y, x] = self.volume
        return field


def fractions(mesh: Any, grid: Grid, sign: str = "auto") -> Fractions:
    """Volumes, areas and centroids of the parts of a grid's cells that a mesh fills, by its triangles clipped at the
    cells' faces. They are those of outer(mesh), so parts may overlap, and their sums are the mesh's volume and area, up to
    rounding. A piece of surface in a face between cells belongs to the cell above.

    sign: 'auto', 'nonzero' or 'parity'. Raises clsdf.Error as outer() does, and invalid_argument unless the grid has two
    samples or more on each axis. Uses all cores, without the GIL. mesh: as for mesh_hash()."""
    vertices, faces, _ = arrays_of(mesh)
    *columns, bits = _core.fractions(vertices, faces, grid, sign)
    shape = tuple(count - 1 for count in grid.shape)
    full = np.unpackbits(bits, count=int(np.prod(shape)), bitorder="little").astype(bool).reshape(shape)
    return Fractions._make((*columns, full, grid))
