"""Files of fields: .nrrd, .npy, .vti, .h5, .nvdb, .sdf; docs/formats.md describes them."""

from __future__ import annotations

import os
from types import TracebackType
from typing import Any

import numpy as np

from . import _core
from ._core import Band, Grid
from ._error import Error
from ._lengths import BandLike, band_without_mesh
from ._values import Outputs, type_of, wanted
from .field import Field


def read_field(path: str | os.PathLike[str]) -> Field:
    """Reads a field by the file's ending, also one of another program. A band that the file does not state has no end;
    a sign rule that it does not state is 'auto'. Raises clsdf.Error: unreadable_input names the file and the value;
    unsupported for an unknown ending."""
    return Field(*_core.read_field(os.fspath(path)))


def write_field(field: Field, path: str | os.PathLike[str]) -> None:
    """Writes a field by the file's ending; complete or not at all. Raises clsdf.Error: output_failure; unsupported for
    an unknown ending, or outputs that the format cannot store."""
    if not isinstance(field, Field):
        raise Error(f"field: {_short(field)} is no clsdf.Field; body.field() and read_field() make them")
    with FieldWriter(
        path, field.grid, field.band, field.sign, field.mesh_name, field.outputs, field.positive_inside
    ) as writer:
        writer.append(field)


class FieldWriter:
    """Writes a field slab by slab, so that it need never be whole in memory. Use it in `with`: the file appears at the
    end, and does not if there was an exception. Raises as write_field() does.

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
    ) -> None:
        if not isinstance(grid, Grid):
            raise Error(f"grid: {_short(grid)} is no clsdf.Grid")
        if not isinstance(band, Band):
            band = band_without_mesh(band, grid)
        self._outputs = wanted(outputs)
        self._writer: _core.Writer | None = _core.writer(
            os.fspath(path), grid, band, sign, mesh_name, self._outputs, positive_inside
        )

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
