"""Grids around a mesh or around bodies, and their fields."""

from __future__ import annotations

import math
import warnings
from collections.abc import Iterable, Sequence
from contextlib import AbstractContextManager
from typing import Any

import numpy as np
import numpy.typing as npt

from . import _core, _cuda
from ._core import Band, Device, Grid
from ._error import Error, MeshWarning
from ._field import Field
from ._lengths import BandLike, LengthLike, band_on, outside_of, parse_band, parse_length
from ._progress import Progress, ProgressFunction
from ._turns import taken
from ._values import Outputs, given, new_samples, wanted, whole
from .typing import OutLike


def _any_given(*options: Any) -> bool:
    return any(value is not None and value is not False for value in options)


def _steps(spacing: float | Sequence[float] | None) -> tuple[float, float, float] | None:
    if spacing is None:
        return None
    try:
        x, y, z = np.broadcast_to(np.asarray(spacing, np.float64), 3).tolist()
    except (TypeError, ValueError):
        raise Error(f"spacing: {spacing!r} is neither a number nor three, (x, y, z)") from None
    return x, y, z


class WithFields:
    """What a Transform and a Scene have alike."""

    _body: _core.Body | _core.Bodies
    #: For messages; made when it is needed.
    _device_name = ""
    #: Of fields, where none is given. A scene computes each body in its band, which is less work than the whole grid each.
    _default_band: BandLike = "full"

    @property
    def device(self) -> Device:
        return self._body.device

    def _description(self) -> tuple[str, str, float | None]:
        """Of a field: the sign rule, the name of the mesh, and the floor of the rule 'below'."""
        raise NotImplementedError

    def grid(
        self,
        resolution: int | None = None,
        *,
        spacing: float | Sequence[float] | None = None,
        margin: LengthLike | None = None,
        cubic: bool = False,
        cell_centred: bool = False,
        band: BandLike | None = None,
    ) -> Grid:
        """The grid that field() makes: around the mesh, or the bodies, at the present positions.

        resolution: samples on the longest side, margin included (256). spacing: instead, in the mesh's units, for all
        axes or each (x, y, z). margin: a length as of `band`; None: the band's half width outside, 5% if it has no end.
        band: as of field(); None: no limit, of a Scene '10%'.
        cubic: as many samples on every axis. cell_centred: samples half a voxel further.
        """
        if resolution is not None and spacing is not None:
            raise Error("resolution= and spacing= exclude each other")
        lower, upper = self._body.box
        samples = 256 if resolution is None else whole("resolution", resolution)
        width = parse_band(self._default_band if band is None else band)
        room = outside_of(width) if margin is None else parse_length("margin", margin)
        return _core.grid_around(lower, upper, samples, _steps(spacing), room, cubic, cell_centred)

    def _grid_and_band(
        self,
        grid: Grid | None,
        band: BandLike,
        resolution: int | None = None,
        spacing: float | Sequence[float] | None = None,
        margin: LengthLike | None = None,
        cubic: bool = False,
        cell_centred: bool = False,
        exact_signs: bool = False,
    ) -> tuple[Grid, Band]:
        """A grid that is given, or one around the mesh; and its band."""
        if grid is None:
            grid = self.grid(resolution, spacing=spacing, margin=margin, cubic=cubic, cell_centred=cell_centred, band=band)
        elif not isinstance(grid, Grid):
            raise Error(f"grid: {grid!r} is not a clsdf.Grid; resolution= takes a number of samples")
        elif _any_given(resolution, spacing, margin, cubic, cell_centred):
            raise Error("a grid that is given excludes resolution=, spacing=, margin=, cubic= and cell_centred=")
        own_band = self._band_on(grid, band)
        if exact_signs and not own_band.exact_signs:
            own_band = Band(own_band.inside, own_band.outside, exact_signs=True)
        return grid, own_band

    def _band_on(self, grid: Grid, band: BandLike) -> Band:
        if isinstance(band, Band):
            return band
        return band_on(parse_band(band), grid, self._longest_side())

    def _longest_side(self) -> float:
        """That of the box of the mesh, or of the bodies."""
        return max(high - low for low, high in zip(*self._body.box))

    def field(
        self,
        grid: Grid | None = None,
        *,
        resolution: int | None = None,
        spacing: float | Sequence[float] | None = None,
        margin: LengthLike | None = None,
        cubic: bool = False,
        cell_centred: bool = False,
        band: BandLike | None = None,
        outputs: Outputs | None = None,
        exact_signs: bool = False,
        out: OutLike | None = None,
        positive_inside: bool = False,
        progress: Progress = None,
        wait_for: Any = None,
        dtype: npt.DTypeLike | None = None,
        image: Any = None,
    ) -> Field:
        """Computes a field: every sample has its exact distance; with a band those within it, and every other one the
        band's half width with its sign.

        grid: a Grid of your own, or that of another field; None: that of `out` if it is a Field, else one around the
            mesh, made by grid() from the options from `resolution` to `cell_centred`.
        band: the half width on both sides, or (inside, outside): '10%' of the longest side of the mesh's box, '3v'
            voxels, a number in the mesh's units, 'full', or a Band. 0: the signs alone. None: that of `out` if it is a
            Field, else 'full', of a Scene '10%'. A band takes less time, of 10% half as long.
        outputs: 'distance gradient triangle' or a list: of 'distance' (always there), 'triangle', 'site', 'closest',
            'gradient', 'barycentric', 'offset', of a Scene 'body'. None: the distance, or what `out` has.
        out: arrays to write to: a Field, a dictionary by names of outputs, or the array of the distance, of the shape
            grid.shape (vectors: one axis more) and any strides. Types: those of a new field; distance, gradient,
            barycentric and offset may also be float64, triangle and body int32 (-1 beyond the band). They may be pyopencl arrays
            of the device's context.
        exact_signs: the field is below 0 at exactly those samples that are inside, on the surface, too: a level set and
            the links and crossings of its grid agree. A Band has it, too.
        dtype: "float64" for distance, gradient, barycentric and offset in double, instead of `out`.
        positive_inside: distances and gradients are negated, also zeros and what lies beyond the band; files record it.
        image: of a Transform: an image of SimpleITK or nibabel, in whose space the mesh is: sample [k, j, i] is voxel
            (i, j, k), whatever its direction. The mesh is taken into the frame of its axes, which is exact. With a
            direction the field's `grid` is that of this frame; vectors are in the image's space. Excludes the options
            of a grid, `out` and `wait_for`.

        Returns `out` if it is a Field, else a new Field. Raises clsdf.Error: invalid_argument before any work for an
        array that is read-only, wrongly shaped, byte-swapped or overlaps another; out_of_memory, device_failure.
        """
        if image is not None:
            if _any_given(grid, resolution, spacing, margin, cubic, cell_centred, out, wait_for):
                raise Error("image= excludes grid=, the options of a grid, out= and wait_for=")
            of_image = self._default_band if band is None else band
            return self._field_of_image(image, of_image, outputs, exact_signs, positive_inside, progress, dtype)
        if isinstance(out, Field) and out.image is not None:
            raise Error("out: a field of an image, whose grid is that of the image's frame; ask for a new one by image=")
        if grid is None and isinstance(out, Field):
            grid = out.grid
        if band is None:
            band = out.band if isinstance(out, Field) else self._default_band
        grid, own_band = self._grid_and_band(grid, band, resolution, spacing, margin, cubic, cell_centred, exact_signs)
        if out is not None and dtype is not None:
            raise Error("dtype= and out= exclude each other: arrays that are given have a type")
        arrays = new_samples(wanted(outputs or ()), grid.shape, dtype) if out is None else given(out, outputs)
        self._warn_of_narrow(grid, own_band)
        field = self._computed(grid, own_band, arrays, positive_inside, progress, wait_for)
        if not isinstance(out, Field):
            return field
        out.grid, out.band, out.sign, out.mesh_name = grid, own_band, field.sign, field.mesh_name
        out.positive_inside, out.floor = positive_inside, field.floor
        return out

    def _field_of_image(
        self,
        image: Any,
        band: BandLike,
        outputs: Outputs | None,
        exact_signs: bool,
        positive_inside: bool,
        progress: Progress,
        dtype: npt.DTypeLike | None,
    ) -> Field:
        raise Error("image: a Transform has fields on the voxels of an image; give a Scene grid=", "unsupported")

    def _turn(
        self, progress: Progress, kind: str, names: Iterable[str] = ()
    ) -> AbstractContextManager[ProgressFunction | None]:
        """shown(), of a call that may compile."""
        if not self._device_name:
            self._device_name = f"{self.device.name} ({self.device.platform})"
        return taken(progress, self._device_name, " ".join((kind, *names)))

    def _computed(
        self,
        grid: Grid,
        band: Band,
        arrays: dict[str, Any],
        positive_inside: bool,
        progress: Progress = None,
        wait_for: Any = None,
    ) -> Field:
        if positive_inside:
            self._check_negatable(arrays, band)
        with self._turn(progress, "field", arrays) as show:
            self._body.compute(grid, band, arrays, show, wait_for)
        if positive_inside:
            _core.negate(arrays)
        sign, name, floor = self._description()
        return Field(grid, band, sign, name, arrays, positive_inside, floor)

    def _warn_of_narrow(self, grid: Grid, band: Band) -> None:
        """The command has these warnings, too."""
        side = self._longest_side() / grid.voxel
        if 0 <= side < 1:
            warnings.warn(
                f"the longest side of the bodies' box is {side:.3g} voxels: are they in the units of the grid?",
                MeshWarning,
                stacklevel=3,
            )
        # 0: that side is not wanted.
        widths = [width for width in (band.outside, self._description()[0] != "none" and band.inside) if width > 0]
        narrow = min(widths, default=math.inf) / grid.voxel
        if narrow < 1:
            warnings.warn(
                f"the band is {narrow:.3g} voxels wide on a side: a surface that is made from the field may be off by a "
                "good part of a voxel, because samples beside it have the band's limit; choose band='2v' or more",
                MeshWarning,
                stacklevel=3,
            )

    def _check_negatable(self, arrays: dict[str, Any], band: Band | None = None) -> None:
        if band is not None and band.inside == band.outside == 0:
            raise Error("positive_inside: a field of signs alone has those of zeros, and these are negative inside")
        if self._description()[0] == "none":
            raise Error("positive_inside: the distances have no sign, so nothing is inside")
        if any(
            hasattr(array, "base_data") or hasattr(array, "int_ptr") or _cuda.is_in_cuda(array)
            for array in arrays.values()
        ):
            raise Error("positive_inside: arrays of the device stay as they are computed; negate them there", "unsupported")
