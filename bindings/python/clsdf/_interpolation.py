"""Values between the samples of a field, and the surface that lies there."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import numpy.typing as npt

from ._core import Grid
from ._error import Error
from ._images import Image
from ._points import on_host, rows_of
from ._values import Samples

#: Points at a time, which bounds the memory of intermediate results.
_at_a_time = 1 << 18


def distance_of(field: Samples) -> npt.NDArray[Any]:
    """The distances as an array of NumPy."""
    distance: Any = field.arrays["distance"]
    return distance.get() if hasattr(distance, "base_data") else on_host(distance)


def interpolated(
    field: Samples, image: Image | None, points: Any, with_gradient: bool
) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.float64] | None]:
    """The results of Field.sample()."""
    rows, shape = rows_of(points)
    rows = on_host(rows)
    values = np.empty(len(rows))
    gradients = np.empty((len(rows), 3)) if with_gradient else None
    distance = distance_of(field)
    for begin in range(0, len(rows), _at_a_time):
        part = slice(begin, begin + _at_a_time)
        at = np.asarray(rows[part], np.float64)
        far = 0.0
        if image is not None:
            far = float(np.abs(image.origin).max())
            at = image.to_frame(at)
        values[part] = _linear(field.grid, distance, at, far, None if gradients is None else gradients[part])
        if image is not None and gradients is not None:
            gradients[part] = image.from_frame(gradients[part], "gradient")
    own = values.reshape(shape)[()]
    return own, None if gradients is None else gradients.reshape(*shape, 3)


def _linear(
    grid: Grid, distance: npt.NDArray[Any], points: npt.NDArray[np.float64], far: float,
    gradients: npt.NDArray[np.float64] | None,
) -> npt.NDArray[np.float64]:
    """Trilinear values at points, NaN outside the grid; their gradients are written. far: how far from 0 they were before
    they were moved into this frame."""
    size, spacing = np.array(grid.size), np.array(grid.spacing)
    steps = (points - grid.origin) / spacing - grid.first
    # A point on the last sample may be rounded beyond it.
    slack = 4 * np.finfo(float).eps * ((np.abs(grid.box).max(0) + 4 * far) / spacing + np.abs(grid.first) + size)
    is_outside = ~((steps >= -slack) & (steps <= size - 1 + slack)).all(1)
    steps = np.clip(np.where(is_outside[:, None], 0, steps), 0, size - 1)
    low = np.minimum(steps.astype(np.int64), np.maximum(size - 2, 0))
    t = steps - low
    (i, j, k), (x, y, z) = low.T, t.T
    right, up, back = (int(count > 1) for count in grid.size)  # an axis of one sample has no neighbour

    def line(dj: int, dk: int) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]]:
        first = distance[k + dk, j + dj, i].astype(np.float64)
        return first, distance[k + dk, j + dj, i + right].astype(np.float64)

    (a, b), (c, d), (e, f), (g, h) = line(0, 0), line(up, 0), line(0, back), line(up, back)
    ab, cd, ef, gh = (p + (q - p) * x for p, q in ((a, b), (c, d), (e, f), (g, h)))
    front, rear = ab + (cd - ab) * y, ef + (gh - ef) * y
    values: npt.NDArray[np.float64] = front + (rear - front) * z
    values[is_outside] = np.nan
    if gradients is not None:
        by_x = ((b - a) * (1 - y) + (d - c) * y) * (1 - z) + ((f - e) * (1 - y) + (h - g) * y) * z
        by_y = (cd - ab) * (1 - z) + (gh - ef) * z
        gradients[:] = np.stack([by_x, by_y, rear - front], 1) / spacing
        gradients[is_outside] = np.nan
    return values


def surface_of(field: Samples, image: Image | None, level: float) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.uint32]]:
    """Vertices and faces of Field.surface()."""
    from skimage.measure import marching_cubes  # type: ignore[import-not-found,import-untyped,unused-ignore]

    inside, outside = field.band.inside, field.band.outside
    lowest, highest = (-outside, inside) if field.positive_inside else (-inside, outside)
    if not lowest < level < highest:
        raise Error(f"level: {level!r} is not within the field's band, {lowest} to {highest}, beyond which it has no surface")
    distance = distance_of(field)
    if min(distance.shape) < 2 or not distance.min() <= level <= distance.max():
        raise Error(f"level: no two neighbours of the field's samples have {level!r} between them")
    cubes: Any = marching_cubes
    corners, faces, _, _ = cubes(np.ascontiguousarray(distance, np.float32), level, allow_degenerate=False)
    grid = field.grid
    vertices = grid.origin + (np.array(grid.first) + corners[:, ::-1].astype(np.float64)) * grid.spacing
    # In the order z, y, x faces are mirrored. Those of values that grow inwards are the other way round.
    is_turned = not field.positive_inside
    if image is not None:
        vertices = image.from_frame(vertices)
        is_turned ^= bool(np.linalg.det(image.direction) < 0)
    faces = faces[:, ::-1] if is_turned else faces
    return vertices, np.ascontiguousarray(faces, np.uint32)


def check_level(level: Any) -> float:
    try:
        number = math.nan if isinstance(level, (bool, str)) else float(level)
    except (TypeError, ValueError):
        number = math.nan
    if not math.isfinite(number):
        raise Error(f"level: {level!r} is not a number, in the mesh's units")
    return number
