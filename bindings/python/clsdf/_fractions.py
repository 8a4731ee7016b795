"""Parts of the cells of a grid that a mesh fills."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any, NamedTuple, overload

import numpy as np
import numpy.typing as npt

from . import _core
from ._core import Grid
from ._error import Error
from ._meshes import OuterSurface, arrays_of


class Fractions(NamedTuple):
    """The cells that the surface meets, a row each, by z, then y, then x. A cell lies between neighbouring samples of the
    grid. The part that is measured is what the mesh encloses, or the fluid around it: see fractions()."""

    cells: npt.NDArray[np.int32]  #: (n, 3), on the lattice: the sample at the low corner
    pieces: npt.NDArray[np.uint32]  #: (n,) parts of the surface in the cell
    volume: npt.NDArray[np.float64]  #: (n,) of the part, as a fraction of the cell
    centroid: npt.NDArray[np.float64]  #: (n, 3) of the part, in cells from the middle of the cell
    area: npt.NDArray[np.float64]  #: (n,) of the surface, in squared units of the mesh
    vector_area: npt.NDArray[np.float64]  #: (n, 3) the integral of the normal out of the solid, in squared units
    surface_centroid: npt.NDArray[np.float64]  #: (n, 3) in cells from the middle of the cell
    face_fractions: npt.NDArray[np.float64]  #: (n, 6) of the part in the low and high face across x, y and z
    face_centroids: npt.NDArray[np.float64]  #: (n, 6, 2) of the part there, along the two other axes
    full: npt.NDArray[np.bool_]  #: (nz - 1, ny - 1, nx - 1): the other cells that are wholly of the part
    grid: Grid

    def __repr__(self) -> str:
        return f"<clsdf.Fractions: {len(self.cells)} cut and {np.count_nonzero(self.full)} full cells of grid {self.grid.shape}>"

    def dense(self, name: str = "volume") -> npt.NDArray[Any]:
        """A column for all cells, (nz - 1, ny - 1, nx - 1), with components last: 'volume', which is 0 or 1 in cells that
        the surface does not meet, or another one, which is 0 there: 'pieces', 'centroid', 'area', 'vector_area',
        'surface_centroid'."""
        if name not in ("volume", "pieces", "centroid", "area", "vector_area", "surface_centroid"):
            raise Error(f"{name!r} is no column of cells; choose 'volume', 'pieces', 'centroid', 'area', 'vector_area' or "
                        "'surface_centroid'")
        rows = getattr(self, name)
        field = np.zeros(self.full.shape + rows.shape[1:], rows.dtype)
        if name == "volume":
            field[self.full] = 1
        field[self._places()] = rows
        return field

    def dense_faces(self) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.float64], npt.NDArray[np.float64]]:
        """The fractions of all faces across x, y and z: an array each, with one face more than cells along that axis."""
        fields = []
        places = self._places()
        for axis in range(3):
            field = np.empty([n + (d == 2 - axis) for d, n in enumerate(self.full.shape)])
            for side in (0, 1):
                shifted = [slice(None)] * 3
                shifted[2 - axis] = slice(side, side + self.full.shape[2 - axis])
                field[tuple(shifted)] = self.full
            for side in (0, 1):
                z, y, x = (place + (side if d == 2 - axis else 0) for d, place in enumerate(places))
                field[z, y, x] = self.face_fractions[:, 2 * axis + side]
            fields.append(field)
        return fields[0], fields[1], fields[2]

    def _places(self) -> tuple[npt.NDArray[np.int64], ...]:
        x, y, z = (self.cells - np.array(self.grid.first)).T
        return z, y, x


@overload
def fractions(
    mesh: Any, grid: Grid, sign: str = "auto", *, convention: str = "plain", part: str | None = None,
    walls: str | None = None, snap: float = 0.0,
) -> Fractions: ...  # fmt: skip
@overload
def fractions(
    mesh: Any, grid: Sequence[Grid], sign: str = "auto", *, convention: str = "plain", part: str | None = None,
    walls: str | None = None, snap: float = 0.0,
) -> list[Fractions]: ...  # fmt: skip
def fractions(
    mesh: Any, grid: Grid | Sequence[Grid], sign: str = "auto", *, convention: str = "plain", part: str | None = None,
    walls: str | None = None, snap: float = 0.0,
) -> Fractions | list[Fractions]:  # fmt: skip
    """Volumes, areas and centroids of the parts of a grid's cells that a mesh fills, by its triangles clipped at the
    cells' faces. They are those of outer(mesh), so parts may overlap, and their sums are the mesh's volume and area, up to
    rounding. An OuterSurface is used as it is: cut once, then used for many grids. Of several grids, as the boxes of an
    AMR hierarchy, a list.

    sign: 'auto', 'nonzero' or 'parity'. convention: 'plain' (the solid), 'amrex' or 'chombo' (the fluid, areas as parts of
    faces) or 'vtk' (centroids as points). part: 'solid' or 'fluid', in place of the convention's; 'solid' with 'amrex' or
    'chombo' is a flow within the mesh: walls between two cells are the solid's, and normals are turned. walls: the cell
    that has a piece of surface in the face between two cells: 'above', or the one on the side of the 'solid' or the
    'fluid'. snap: vertices so near to a plane between cells are moved onto it, in cells, at most 0.001.

    Raises clsdf.Error as outer() does, and invalid_argument unless the grid has two samples or more on each axis. Uses all
    cores, without the GIL. mesh: as for mesh_hash()."""
    grids = list(grid) if isinstance(grid, Iterable) else [grid]
    for one in grids:
        if not isinstance(one, Grid):
            raise Error(f"grid: {one!r} is no clsdf.Grid; body.grid(resolution=...) makes one")
    mesh = getattr(mesh, "surface", mesh) if isinstance(mesh, tuple) else mesh  # of a SceneSurface
    is_outer = isinstance(mesh, OuterSurface)
    vertices, faces, _ = arrays_of(mesh.mesh if is_outer else mesh)
    found = _core.fractions(vertices, faces, grids, sign, is_outer, convention, part or "", walls or "", snap)
    all_cells = []
    for own, (*columns, bits) in zip(grids, found):
        shape = tuple(count - 1 for count in own.shape)
        full = np.unpackbits(bits, count=int(np.prod(shape)), bitorder="little").astype(bool).reshape(shape)
        all_cells.append(Fractions._make((*columns, full, own)))
    return all_cells[0] if isinstance(grid, Grid) else all_cells
