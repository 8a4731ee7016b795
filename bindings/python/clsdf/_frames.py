"""Motions of rigid bodies: rotations, translations and poses as users give them, and results in the frame of a body."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from . import _core, _cuda
from ._error import Error
from ._meshes import refuse_graph
from ._points import on_host


def vectors(name: str, values: Any, shape: tuple[int, ...]) -> npt.NDArray[np.float64]:
    refuse_graph(name, values, "move the points instead, clsdf.torch.signed_distance(body, (points - t) @ R), or ")
    try:
        array = np.asarray(values, np.float64)
    except (TypeError, ValueError):
        raise Error(f"{name}: {values!r} is no array of numbers of the shape {shape}") from None
    if array.shape != shape:
        raise Error(f"{name} has the shape {array.shape}; expected {shape}")
    return array


def matrix_of(motion: Any) -> Any:
    """The matrix of scipy's Rotation or RigidTransform; all else as it is."""
    as_matrix = getattr(motion, "as_matrix", None)
    return motion if as_matrix is None else as_matrix()


#: A rotation (3, 3) and a translation (3,).
Motion = tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]]


def motion_of(name: str, rotation: Any, translation: Any = None) -> Motion:
    """The motion of a rotation and a translation, or of a pose; a rotation in floats is made one in double."""
    matrix = matrix_of(rotation)
    if translation is None and matrix is not rotation and np.shape(matrix) == (3, 3):  # a Rotation alone
        translation = np.zeros(3)
    rotation = matrix
    if translation is None:
        pose = vectors(name, rotation, (4, 4))
        if pose[3].tolist() != [0, 0, 0, 1]:
            raise Error(f"{name}: the last row of the 4 x 4 matrix is {pose[3].tolist()}, not [0, 0, 0, 1]")
        rotation, translation = pose[:3, :3], pose[:3, 3]
    turn, shift = vectors(name, rotation, (3, 3)), vectors("translation", translation, (3,))
    error = np.abs(turn @ turn.T - np.eye(3)).max()
    if not error <= 1e-5 or not np.linalg.det(turn) > 0:
        if error <= 1e-5:
            raise Error(f"{name}: the matrix is no rotation, but a reflection, which would turn the mesh inside out; mirror "
                        "the vertices, and exchange two vertices of each face, before you add it")
        raise Error(
            f"{name}: the matrix is no rotation to 1e-5, but {error:.2g} off; "
            "u, _, v = numpy.linalg.svd(matrix) makes the nearest one, u @ v, of a matrix that is nearly one, and "
            "scipy.spatial.transform.Rotation makes one of angles or a quaternion, and is one; a pose has no scale: scale "
            "the vertices"
        )
    if not np.isfinite(shift).all():
        raise Error(f"translation: {shift.tolist()} is not finite")
    if error > 1e-12:  # not a rotation in double
        turn = np.array(_core.rotation_near(turn.tolist()), np.float64)
    return turn, shift.copy()


def frame_of(frame: Any) -> Motion:
    """The motion of (R, t), of a pose, or of a rotation of scipy."""
    parts = frame if isinstance(frame, (tuple, list)) and len(frame) == 2 else (frame,)
    return motion_of("frame", *parts)


def into_frame(points: Any, rotation: npt.NDArray[np.float64], translation: npt.NDArray[np.float64]) -> Any:
    """Points of the world in the frame of a body. Sums are written out: a product of matrices is another one on other
    processors."""
    if hasattr(points, "base_data") or _cuda.is_in_cuda(points):
        raise Error(
            "frame: the points are in memory of the device; take them into the frame there, (points - t) @ R, or copy "
            "them to a NumPy array",
            "unsupported",
        )
    points = on_host(points)
    x, y, z = (points.T - translation[:, None]).astype(np.float64)
    return np.stack([x * rotation[0, a] + y * rotation[1, a] + z * rotation[2, a] for a in range(3)], axis=1)


def out_of_frame(
    arrays: dict[str, Any], rotation: npt.NDArray[np.float64], translation: npt.NDArray[np.float64]
) -> None:
    """Turns the vectors of results, and moves the closest points, in place."""
    for name in ("gradient", "offset", "closest"):
        if name in arrays:
            x, y, z = arrays[name].astype(np.float64).T
            shift = translation if name == "closest" else np.zeros(3)
            for a in range(3):
                arrays[name][:, a] = x * rotation[a, 0] + y * rotation[a, 1] + z * rotation[a, 2] + shift[a]
