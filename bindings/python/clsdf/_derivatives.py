"""Distances at points with what their derivatives need, as NumPy arrays: for clsdf.torch and clsdf.jax."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from ._error import Error
from ._transform import Transform

#: Of a distance that is differentiated again.
no_second = "the second derivative of a signed distance is not computed; take differences of the first, or detach it"


class Found(NamedTuple):
    """Distances (...), and None for what was not asked for. The nearest point of the mesh is weights @
    vertices[corners]. All but the distance is 0 if a point has no nearest triangle."""

    distance: npt.NDArray[Any]
    gradient: npt.NDArray[Any] | None  #: (..., 3), by the point
    corners: npt.NDArray[np.int64] | None  #: (..., 3), vertices of the nearest triangle
    weights: npt.NDArray[Any] | None  #: (..., 3), of the corners


def check(body: Any, points: Any, vertices: Any, floats: Any) -> None:
    """Refuses what is no transform, and arrays that are not of these two types or have wrong shapes."""
    if not isinstance(body, Transform):
        raise Error(f"body: {repr(body)[:100]} is no clsdf.Transform")
    if tuple(points.shape)[-1:] != (3,):
        raise Error(f"points has the shape {tuple(points.shape)}; expected (..., 3)")
    if vertices is not None and body._made_of.surface != "given":
        raise Error("vertices: where faces cut each other no one face has the derivative; make the body with surface='given'")
    if vertices is not None and tuple(vertices.shape) != (own := body.vertices.shape):
        raise Error(f"vertices has the shape {tuple(vertices.shape)}; the body's have {own}")
    for name, array in (("points", points), ("vertices", vertices)):
        if array is not None and array.dtype not in floats:
            raise Error(f"{name}: numbers of {array.dtype} are not taken; pass float32 or float64")


def find(
    body: Transform,
    points: npt.NDArray[Any],
    vertices: npt.NDArray[Any] | None,
    within: float | None,
    real: npt.DTypeLike,
    by_points: bool,
    by_vertices: bool,
) -> Found:
    """The distances at points (..., 3). vertices: positions that the body gets before, if it has others."""
    outputs = ["triangle", "gradient"] if by_points or by_vertices else []
    if by_vertices:
        outputs.append("barycentric")
    with body._moves:  # no thread sets other positions before the query
        if vertices is not None and not np.array_equal(body.vertices, vertices):
            body.set_positions(vertices)
        found = body.query(points, outputs, within=within, dtype=real)
    distance = np.asarray(found.distance)
    if not outputs:
        return Found(distance, None, None, None)
    triangle = np.asarray(found.triangle)
    is_beyond = triangle == 0xFFFFFFFF
    gradient = np.where(is_beyond[..., None], 0, found.gradient)
    if not by_vertices:
        return Found(distance, gradient, None, None)
    corners = body.faces[np.where(is_beyond, 0, triangle)].astype(np.int64)
    two = np.where(is_beyond[..., None], 0, found.barycentric)
    first = np.where(is_beyond, 0, 1 - two[..., 0] - two[..., 1])
    return Found(distance, gradient, corners, np.concatenate([first[..., None], two], -1))
