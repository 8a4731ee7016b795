"""Takes the place of trimesh.proximity for distances, with its results: positive inside, float64.

    import clsdf.trimesh as proximity      # was: from trimesh import proximity
    proximity.signed_distance(mesh, points)

A mesh is prepared at its first call. The same mesh object is not prepared again until its vertices or faces change.
"""

from __future__ import annotations

import threading
import weakref
from typing import Any

import numpy as np
import numpy.typing as npt

from ._error import Error
from ._transform import Transform

# By id(mesh): the mesh, its hash at that time, and its transform. A mesh that ends takes its row with it.
_prepared: dict[int, tuple[weakref.ref[Any], int, dict[str, Transform]]] = {}
_lock = threading.Lock()


def _transform_of(mesh: Any, sign: str) -> Transform:
    if not hasattr(mesh, "is_watertight"):  # the hash of another object does not change with its vertices
        raise Error(f"mesh is a {type(mesh).__qualname__}, not a trimesh.Trimesh; clsdf.Transform() takes others")
    key, state = id(mesh), hash(mesh)
    with _lock:
        row = _prepared.get(key)
        if row is None or row[0]() is not mesh or row[1] != state:
            row = (weakref.ref(mesh, lambda _: _prepared.pop(key, None)), state, {})
            _prepared[key] = row
        if sign not in row[2]:
            row[2][sign] = Transform(mesh, sign=sign)
        return row[2][sign]


def _points_of(points: npt.ArrayLike) -> npt.NDArray[np.float64]:
    rows = np.asarray(points, np.float64)
    if rows.ndim != 2 or rows.shape[1] != 3:
        raise Error(f"points has the shape {rows.shape}; expected (n, 3), as trimesh does")
    return rows


def signed_distance(mesh: Any, points: npt.ArrayLike) -> npt.NDArray[np.float64]:
    """trimesh.proximity.signed_distance: the distances (n,), float64, of points (n, 3) to the surface, positive inside,
    negative outside, and 0 on the surface.

    The sign is exact. Raises clsdf.Error: invalid_mesh if the mesh has no inside, because it is open; trimesh returns a
    guess then.
    """
    rows = _points_of(points)
    body = _transform_of(mesh, "auto" if getattr(mesh, "is_watertight", False) else "nonzero")
    distance = np.empty(len(rows), np.float64)
    body.query(rows, out=distance)
    return 0.0 - distance  # 0 stays +0


def closest_point(
    mesh: Any, points: npt.ArrayLike
) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.float64], npt.NDArray[np.int64]]:
    """trimesh.proximity.closest_point: for points (n, 3) the closest points on the surface (n, 3), their distances (n,),
    which are not negative, and the indices of their triangles (n,). At an edge or a vertex the triangle is the lowest
    that shares it. Any mesh will do."""
    rows = _points_of(points)
    distance, closest = np.empty(len(rows), np.float64), np.empty((len(rows), 3), np.float64)
    triangle = np.empty(len(rows), np.uint32)
    out: dict[str, npt.NDArray[Any]] = {"distance": distance, "closest": closest, "triangle": triangle}
    _transform_of(mesh, "none").query(rows, out=out)
    return closest, distance, triangle.astype(np.int64)


class ProximityQuery:
    """trimesh.proximity.ProximityQuery, which is also a mesh's `nearest`: its signed_distance() and on_surface()."""

    def __init__(self, mesh: Any) -> None:
        self._mesh = mesh

    def __repr__(self) -> str:
        return f"<clsdf.trimesh.ProximityQuery: {self._mesh!r}>"

    def signed_distance(self, points: npt.ArrayLike) -> npt.NDArray[np.float64]:
        """signed_distance() of the mesh."""
        return signed_distance(self._mesh, points)

    def on_surface(
        self, points: npt.ArrayLike
    ) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.float64], npt.NDArray[np.int64]]:
        """closest_point() of the mesh."""
        return closest_point(self._mesh, points)
