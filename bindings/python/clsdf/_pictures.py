"""Pictures of slices that a notebook shows, with axes and a scale if matplotlib is installed."""

from __future__ import annotations

import importlib.util
import os
import struct
import zlib
from collections.abc import Sequence
from typing import Any

import numpy as np

from ._complete import complete
from ._error import Error
from ._values import Samples

_inside, _outside = np.array([40, 90, 170.0]), np.array([200, 110, 50.0])
_white, _line = np.array([255, 255, 255.0]), np.array([20, 20, 20.0])


class Picture:
    """A picture, which a notebook shows by itself. pixels: an array (height, width, 3) of uint8, from the top."""

    def __init__(self, pixels: np.ndarray[Any, Any]) -> None:
        self.pixels = pixels

    def __repr__(self) -> str:
        height, width, _ = self.pixels.shape
        return f"<clsdf.Picture: {width} x {height} pixels>"

    def _repr_png_(self) -> bytes:
        return self.png()

    def png(self) -> bytes:
        """The bytes of a PNG file."""
        height, width, _ = self.pixels.shape
        rows = np.zeros((height, 1 + 3 * width), np.uint8)  # each row begins with its filter: 0, none
        rows[:, 1:] = self.pixels.reshape(height, -1)
        header = struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
        chunks = ((b"IHDR", header), (b"IDAT", zlib.compress(rows.tobytes(), 6)), (b"IEND", b""))
        return b"\x89PNG\r\n\x1a\n" + b"".join(
            struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
            for kind, data in chunks
        )

    def save(self, path: str | os.PathLike[str]) -> None:
        """Writes a PNG file; the path ends in .png. Raises clsdf.Error: unsupported for another ending;
        output_failure."""
        name = os.fsdecode(path)
        if not name.lower().endswith(".png"):
            raise Error(f"{name}: pictures are written as PNG; end the path with .png", "unsupported")

        def write(unfinished: str) -> None:
            with open(unfinished, "wb") as file:
                file.write(self.png())

        complete(name, ".png", write)


def of_slice(
    field: Samples, coordinates: Sequence[np.ndarray[Any, Any]], axis: str, index: int | None, pixels: int, axes: bool | None
) -> Picture:
    """The picture of slice_picture(). coordinates: of the samples along x, y and z."""
    if axis not in ("x", "y", "z"):
        raise Error(f"axis: {axis!r} is not an axis; write 'x', 'y' or 'z'")
    along = "zyx".index(axis)
    count = field.distance.shape[along]
    chosen = count // 2 if index is None else index
    if not 0 <= chosen < count:
        raise Error(f"index: the field has no slice {chosen} along {axis}; it has {count}")
    values = np.asarray(field.distance.take(chosen, axis=along))[::-1]  # the last row is the lowest
    if axes or (axes is None and min(values.shape) > 1 and importlib.util.find_spec("matplotlib") is not None):
        return _with_axes(field, dict(zip("xyz", coordinates)), axis, chosen, values[::-1], pixels)
    limit = float(np.abs(values[np.isfinite(values)]).max(initial=0)) or 1.0
    part = np.clip(np.abs(values) / limit, 0, 1)[..., None] * 0.8 + 0.1
    inside = np.signbit(values) != field.positive_inside
    colours = _white + (np.where(inside[..., None], _inside, _outside) - _white) * part
    scale = max(1, pixels // max(values.shape))
    colours = colours.repeat(scale, 0).repeat(scale, 1)
    side = inside.repeat(scale, 0).repeat(scale, 1)
    edge = np.zeros(side.shape, bool)
    edge[1:] |= side[1:] != side[:-1]
    edge[:, 1:] |= side[:, 1:] != side[:, :-1]
    if field.sign != "none":
        colours[edge] = _line
    return Picture(np.clip(colours, 0, 255).astype(np.uint8))


def _with_axes(
    field: Samples, coordinates: dict[str, np.ndarray[Any, Any]], axis: str, index: int, values: np.ndarray[Any, Any], pixels: int
) -> Picture:
    """The slice by matplotlib. Its figure is not that of pyplot, so no state of a program changes."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg  # type: ignore[import-not-found,unused-ignore]
    from matplotlib.colors import LinearSegmentedColormap  # type: ignore[import-not-found,unused-ignore]
    from matplotlib.figure import Figure  # type: ignore[import-not-found,unused-ignore]

    (right, columns), (up, rows) = ((name, at) for name, at in coordinates.items() if name != axis)
    half = [0.5 * field.grid.spacing["xyz".index(name)] for name in (right, up)]
    limit = float(np.abs(values[np.isfinite(values)]).max(initial=0)) or 1.0
    colours = [_inside / 255, _white / 255, _outside / 255]
    figure = Figure(figsize=(pixels / 100, 0.8 * pixels / 100), dpi=100, layout="constrained")
    canvas: Any = FigureCanvasAgg(figure)
    plot = figure.add_subplot()
    image = plot.imshow(
        values,
        cmap=LinearSegmentedColormap.from_list("distance", colours[::-1] if field.positive_inside else colours),
        vmin=-limit,
        vmax=limit,
        origin="lower",
        interpolation="bilinear",
        extent=(columns[0] - half[0], columns[-1] + half[0], rows[0] - half[1], rows[-1] + half[1]),
    )
    inside = np.signbit(values) != field.positive_inside
    if field.sign != "none" and inside.any() and not inside.all():
        # A field of signs alone has no level 0 between its samples.
        has_values = np.any(values != 0)
        plot.contour(columns, rows, values if has_values else inside, [0 if has_values else 0.5], colors="black")
    plot.set(xlabel=right, ylabel=up, title=f"{axis} = {coordinates[axis][index]:.4g}")
    figure.colorbar(image, label="distance, positive inside" if field.positive_inside else "signed distance")
    canvas.draw()
    return Picture(np.array(canvas.buffer_rgba())[..., :3].copy())
