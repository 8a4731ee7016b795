"""Lengths and bands as users write them: "10%", "3v", 0.05, "full"; docs/grids-and-bands.md has their meaning."""

from __future__ import annotations

import math
from typing import Union

import numpy as np

from ._core import Band, Grid, Length
from ._error import Error

LengthLike = Union[str, float]
BandLike = Union[LengthLike, "tuple[LengthLike, LengthLike]", Band]


def parse_length(what: str, value: LengthLike) -> Length:
    """The length that a number (in the mesh's units) or a text means. `what` names it in the error."""
    if isinstance(value, str):
        length = Length.parse(value, what)
        if not length.is_infinite() and value[-1] not in "%v":
            raise Error(f"{what}: {value!r} is a text without a unit: write the number {value} (the mesh's units), "
                        f"'{value}%' (of the longest side of the mesh's box) or '{value}v' (voxels)")
        return length
    try:
        number = math.nan if isinstance(value, (bool, np.bool_)) else float(value)
    except (TypeError, ValueError):
        number = math.nan
    if not number >= 0:
        raise Error(
            f"{what}: {value!r} is not a length: write '10%' (of the longest side of the mesh's box), '3v' (voxels), "
            "0.05 (the mesh's units) or 'full'"
        )
    return Length.infinite() if math.isinf(number) else Length.in_mesh_units(number)


def parse_band(band: BandLike) -> tuple[Length, Length] | Band:
    """The half widths inside and outside."""
    if isinstance(band, Band):
        return band
    if isinstance(band, (tuple, list)):
        if len(band) != 2:
            raise Error(f"band: {band!r} has {len(band)} widths; write one, or (inside, outside)")
        return parse_length("band inside", band[0]), parse_length("band outside", band[1])
    width = parse_length("band", band)
    return width, width


def band_without_mesh(band: BandLike, grid: Grid) -> Band:
    """The band on a grid, if it is not a part of the mesh's box."""
    lengths = parse_band(band)
    if isinstance(lengths, Band):
        return lengths
    inside, outside = (length.resolve(grid.voxel, math.nan) for length in lengths)
    if math.isnan(inside) or math.isnan(outside):
        raise Error(f"band: {band!r} is a part of the mesh's box, which is not known here; write a number, '3v' or "
                    "'full', or pass the band of a field")
    return Band(inside, outside)


def outside_of(band: tuple[Length, Length] | Band) -> Length:
    """The half width outside, which is the default of a grid's margin; 5% if it has no end."""
    outside = band[1] if isinstance(band, tuple) else Length.in_mesh_units(band.outside)
    endless = outside.is_infinite() or (isinstance(band, Band) and math.isinf(band.outside))
    return Length.of_extent(0.05) if endless else outside


def band_on(band: tuple[Length, Length] | Band, grid: Grid, extent: float) -> Band:
    """The band in the mesh's units, for a grid and the longest side of the mesh's box."""
    if isinstance(band, Band):
        return band
    return Band(band[0].resolve(grid.voxel, extent), band[1].resolve(grid.voxel, extent))
