"""Files of fields: .nrrd, .npy, .vti, .vtkhdf, .h5, .nvdb, .sdf; docs/formats.md describes them."""

from __future__ import annotations

import math
import os
import warnings
from collections.abc import Iterable
from types import TracebackType
from typing import Any

import numpy as np

from . import _core
from ._core import Band, Grid
from ._error import Error, MeshWarning
from ._lengths import BandLike, band_without_mesh
from ._meshes import Groups
from ._values import Outputs, type_of, wanted
from ._field import Field


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
        from . import _images

        _images.write(field, field.image, os.fsdecode(path))
        return
    writer = FieldWriter.__new__(FieldWriter)
    writer._open(
        path,
        field.grid,
        field.band,
        field.sign,
        field.mesh_name,
        field.outputs,
        field.positive_inside,
        groups,
        field.floor,
    )
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
        self._open(path, grid, band, sign, mesh_name, wanted(outputs), positive_inside, groups, floor)

    def _open(
        self,
        path: str | os.PathLike[str],
        grid: Grid,
        band: Band,
        sign: str,
        mesh_name: str,
        outputs: tuple[str, ...],
        positive_inside: bool,
        groups: Groups | None = None,
        floor: float | None = None,
    ) -> None:
        if groups is not None and not isinstance(groups, Groups):
            raise Error(f"groups: {repr(groups)[:100]} is no clsdf.Groups; read_mesh(path).groups is one")
        names: list[str] = [] if groups is None else groups.names
        numbers = None if groups is None else np.ascontiguousarray(groups.numbers, np.int32)
        name = os.fsdecode(path)
        self._path = name
        self._writer: _core.Writer | None = _core.writer(
            name, grid, band, sign, mesh_name, outputs, positive_inside, names, numbers, floor
        )
        if name.lower().endswith(".sdf") and (positive_inside or not math.isinf(max(band.inside, band.outside))):
            warnings.warn(
                f"{name} does not state that it is positive inside: tell it to those who read it, or use another format"
                if positive_inside
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
