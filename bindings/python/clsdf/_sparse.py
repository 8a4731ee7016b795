"""A sparse field: values near the surface only, and the sign of the rest."""

from __future__ import annotations

import os
from typing import Any

import numpy as np
import numpy.typing as npt

from . import _core
from ._core import Band, Grid
from ._error import Error
from ._values import Samples, shape_of, type_of


class SparseField(Samples):
    """The bricks of a grid that are near the surface, 8 x 8 x 8 samples each, and the sign of the rest.

    Bricks tile the lattice from its sample (0, 0, 0). One has values if a sample of it is in the band, or if it has
    samples of both signs; all samples of another brick are beyond the band, on one side.

    bricks: (n, 3) int64, the first sample (i, j, k) of each brick with values, on the lattice; sorted by k, then j, then
        i. Arrays of outputs have the shape (n, 8, 8, 8), z first: f.distance[m, c, b, a] is the sample
        f.bricks[m] + (a, b, c). Vectors have one axis more.
    inside: (m, 4) int64, bricks without values that are inside: a row (i, j, k, count) stands for `count` bricks along x
        from the sample (i, j, k) on.
    grid, band, sign, mesh_name, positive_inside, floor: as of a Field. Bricks at the grid's end have values of samples beyond
        the grid, too.
    """

    def __init__(
        self,
        grid: Grid,
        band: Band,
        sign: str,
        mesh_name: str,
        bricks: npt.NDArray[np.int64],
        inside: npt.NDArray[np.int64],
        arrays: dict[str, Any],
        positive_inside: bool = False,
        floor: float | None = None,
    ) -> None:
        super().__init__(grid, band, sign, mesh_name, arrays, positive_inside, floor)
        self.bricks = bricks
        self.inside = inside

    def __repr__(self) -> str:
        return (
            f"<clsdf.SparseField: {', '.join(self.outputs)}, {len(self.bricks)} bricks of grid {self.grid.shape}, "
            f"sign {self.sign}>"
        )

    def __len__(self) -> int:
        """The number of bricks with values."""
        return len(self.bricks)

    def find(self, samples: npt.ArrayLike) -> Any:
        """The number of the brick that has the values of each sample: for an array (..., 3) of whole numbers (i, j, k)
        on the lattice an array (...), for one sample (3,) a number; -1 for a sample that is in no brick with values."""
        rows, shape = _samples(samples)
        numbers = _core.find_bricks(_packed(self.bricks, np.int64), rows).reshape(shape)
        return numbers[()]

    def distance_at(self, samples: npt.ArrayLike) -> Any:
        """The distance of each sample, near the surface or not, with the bits of a dense field: for an array (..., 3) of
        whole numbers (i, j, k) on the lattice an array (...), float32, for one sample (3,) a number. Samples lie in the
        bricks of the grid."""
        rows, shape = _samples(samples)
        whole = self.grid.in_whole_bricks()
        first = np.array(whole.first)
        outside = ((rows < first) | (rows >= first + whole.size)).any(1)
        if outside.any():
            n = int(outside.argmax())
            raise Error(
                f"samples: {tuple(rows[n].tolist())} is not in the bricks of the grid, from {whole.first} on "
                f"{' x '.join(map(str, whole.size))} samples; indices count on the lattice, and grid.first is that of "
                "the grid's first sample"
            )
        results = np.empty(len(rows), np.float32)
        distance = _packed(self.distance, np.float32)
        bricks, inside = _packed(self.bricks, np.int64), _packed(self.inside, np.int64)
        _core.sparse_distances(bricks, inside, distance, self.band, rows, results)
        if self.positive_inside:  # the bricks' values are negated already
            far = _core.find_bricks(bricks, rows) < 0
            results[far] = -results[far]
        return results.reshape(shape)[()]

    def write(self, path: str | os.PathLike[str]) -> None:
        """Writes a .nvdb (NanoVDB, a float level set), .npy, .h5 or, if OpenVDB is built in, .vdb; complete or not at
        all. Raises clsdf.Error: output_failure; unsupported for another ending, or outputs that the format cannot
        store."""
        arrays = {name: _packed(array, type_of(name)[0]) for name, array in self.arrays.items()}
        bricks, inside = _packed(self.bricks, np.int64), _packed(self.inside, np.int64)
        _core.write_sparse(
            os.fsdecode(path), self.grid, self.band, self.sign, self.mesh_name, self.positive_inside,
            bricks, inside, arrays, self.floor,
        )  # fmt: skip


def made(
    grid: Grid,
    band: Band,
    sign: str,
    mesh_name: str,
    outputs: tuple[str, ...],
    found: tuple[Any, Any, dict[str, Any]],
    positive_inside: bool,
    floor: float | None,
) -> SparseField:
    """A field of what the extension has computed."""
    bricks, inside, arrays = _with_empty(found, outputs)
    if positive_inside:
        _core.negate(arrays)
    return SparseField(grid, band, sign, mesh_name, bricks, inside, arrays, positive_inside, floor)


def read_sparse_field(path: str | os.PathLike[str]) -> SparseField | None:
    """Reads the sparse field of a .nvdb, .npy, .h5 or, if OpenVDB is built in, .vdb. None if the file has a dense field,
    which read_field() reads; that function also makes a sparse field dense. The bricks of .nvdb and .vdb are their leaves;
    samples beyond the grid have the background. Raises as read_field()."""
    read = _core.read_sparse_field(os.fsdecode(path))
    if read is None:
        return None
    grid, band, sign, mesh_name, found, positive_inside, floor = read
    return SparseField(grid, band, sign, mesh_name, *_with_empty(found, ("distance",)), positive_inside, floor)


def _with_empty(found: tuple[Any, Any, dict[str, Any]], outputs: tuple[str, ...]) -> tuple[Any, Any, dict[str, Any]]:
    """Arrays without items in place of those that the extension leaves out."""
    bricks, inside, arrays = found
    if bricks is None:
        bricks = np.empty((0, 3), np.int64)
        arrays = {name: np.empty(shape_of(name, (0, 8, 8, 8)), type_of(name)[0]) for name in outputs}
    if inside is None:
        inside = np.empty((0, 4), np.int64)
    return bricks, inside, arrays


def _samples(samples: Any) -> tuple[npt.NDArray[np.int64], tuple[int, ...]]:
    rows = np.asarray(samples)
    if rows.shape == (0,):
        rows = np.empty((0, 3), np.int64)
    if rows.dtype.kind not in "iu" or rows.shape[-1:] != (3,):
        raise Error(
            f"samples has the shape {rows.shape} and the type {rows.dtype}; expected whole numbers (..., 3), the indices "
            "(i, j, k) of samples on the lattice"
        )
    return np.ascontiguousarray(rows.reshape(-1, 3), np.int64), rows.shape[:-1]


def _packed(array: Any, dtype: Any) -> Any:
    return np.ascontiguousarray(array, dtype)
