"""Where links of a lattice and edges of a grid meet the surface."""

from __future__ import annotations

from typing import Any, Union

import numpy as np
import numpy.typing as npt

from . import _core
from ._core import Grid
from ._error import Error
from ._values import real_of


def grid_of(grid: Any) -> Grid:
    if not isinstance(grid, Grid):
        raise Error(f"grid: {repr(grid)[:100]} is no clsdf.Grid; grid() of the body makes one")
    return grid


def stencil(name: str, code: str = "waLBerla") -> npt.NDArray[np.int32]:
    """The directions of a lattice-Boltzmann stencil, (Q, 3), in the order of a code: "D3Q15", "D3Q19" or "D3Q27";
    "OpenLB", "waLBerla", "lbmpy", "Palabos" or "XLB". The first one is (0, 0, 0), which has no links."""
    return _core.stencil(name, code)


class Links:
    """The links of a grid that meet the surface, a row each, by sample (z, then y, then x), then by direction.

    A link begins at its row's sample, which is in the grid and outside, and ends a direction farther.

    samples: (n, 3) int32, on the lattice (grid.first is that of the grid's first sample).
    directions: (n,) uint8, rows of `stencil`.
    q: (n,) the part of the link up to the first wall: 0 (the sample is on the wall) to 1.
    triangles: (n,) uint32, the lowest of those met there, in the group mesh.groups.numbers[links.triangles];
        clsdf.no_triangle at the film of an open mesh and at the walls and the floor of the sign rule below.
    counts: (n,) uint32, walls on the link.
    flags: (n,) uint8, bits: 1 the film of an open mesh, 2 both ends are outside with a body between them, 8 (of
        hits="faces") both ends are on one side, 16 the wall is one of the walls or the floor of the sign rule below.
    inside: (nz, ny, nx) bool, the samples of the grid that are inside: on a wall outside, on a face within a body inside.
    stencil: (Q, 3) int32, the directions. grid: as given.
    """

    FILM, BETWEEN, SHEET, CLOSING = 1, 2, 8, 16

    def __init__(self, grid: Grid, directions: npt.NDArray[np.int32], found: tuple[Any, ...]) -> None:
        self.grid = grid
        self.stencil = directions
        self.samples, self.directions, self.q, self.triangles, self.counts, self.flags, bits = found
        self.inside = _samples_of(bits, grid)

    def __len__(self) -> int:
        return len(self.q)

    def __repr__(self) -> str:
        return f"<clsdf.Links: {len(self)} links in {len(self.stencil)} directions of grid {self.grid.shape}>"

    def dense(self) -> npt.NDArray[Any]:
        """q by direction and sample, (Q, nz, ny, nx); -1 where there is no link."""
        field = np.full((len(self.stencil), *self.grid.shape), -1, self.q.dtype)
        x, y, z = (self.samples - np.array(self.grid.first)).T
        field[self.directions, z, y, x] = self.q
        return field


class EdgeCrossings:
    """Where the edges of a grid along one axis meet walls. Edge [k, j, i] joins a sample with the next one along the
    axis, so the arrays have one item less on it.

    coordinates: float64, along the axis, of the first wall from the end that is outside; NaN if the sides agree.
    triangles: uint32, or clsdf.no_triangle. counts: uint32, walls on the edge, also where the sides agree; or None.
    """

    def __init__(self, arrays: tuple[Any, Any, Any]) -> None:
        self.coordinates: npt.NDArray[np.float64]
        self.triangles: npt.NDArray[np.uint32]
        self.counts: npt.NDArray[np.uint32] | None
        self.coordinates, self.triangles, self.counts = arrays

    def _crossed(self) -> int:
        return int(np.count_nonzero(~np.isnan(self.coordinates)))

    def __repr__(self) -> str:
        return f"<clsdf.EdgeCrossings: {self._crossed()} in arrays of shape {self.coordinates.shape}>"


class Crossings:
    """Where the edges of a grid meet walls: x, y and z are EdgeCrossings along these axes. inside: (nz, ny, nx) bool, as
    of Links. grid: as given."""

    def __init__(self, grid: Grid, found: tuple[Any, Any]) -> None:
        self.grid = grid
        axes, bits = found
        self.x, self.y, self.z = (EdgeCrossings(arrays) for arrays in axes)
        self.inside = _samples_of(bits, grid)

    def __repr__(self) -> str:
        x, y, z = (axis._crossed() for axis in (self.x, self.y, self.z))
        return f"<clsdf.Crossings: {x} along x, {y} along y and {z} along z of grid {self.grid.shape}>"


#: A stencil by name, by name and code, or whole numbers (n, 3).
DirectionsLike = Union[str, tuple[str, str], npt.ArrayLike]


def directions_of(directions: DirectionsLike) -> npt.NDArray[np.int32]:
    """The directions of a name, of a name and a code, or of an array (n, 3)."""
    if isinstance(directions, str):
        return stencil(directions)
    if isinstance(directions, tuple) and len(directions) == 2 and all(isinstance(part, str) for part in directions):
        return stencil(*directions)
    try:
        given = np.asarray(directions)
    except ValueError:
        raise Error(f"directions: {repr(directions)[:100]} is no array (n, 3); each direction has three whole numbers") from None
    if given.ndim != 2 or given.shape[1:] != (3,) or given.dtype.kind not in "iu":
        raise Error(
            f"directions has the shape {given.shape} and the type {given.dtype}; expected whole numbers (n, 3), a name as "
            "'D3Q19', or ('D3Q19', 'OpenLB')"
        )
    if given.min(initial=0) < -16 or given.max(initial=0) > 16:
        raise Error("directions: components are at most 16")
    return np.ascontiguousarray(given, np.int32)


def is_in_floats(dtype: npt.DTypeLike) -> bool:
    return real_of(np.float64 if dtype is None else dtype) == np.float32


def is_of_faces(hits: str) -> bool:
    if hits not in ("walls", "faces"):
        raise Error(f"hits is {hits!r}; the choices are 'walls' and 'faces'")
    return hits == "faces"


def _samples_of(bits: npt.NDArray[np.uint8], grid: Grid) -> npt.NDArray[np.bool_]:
    count = int(np.prod(grid.shape))
    return np.unpackbits(bits, count=count, bitorder="little").reshape(grid.shape).view(np.bool_)
