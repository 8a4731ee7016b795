"""Many bodies with poses, and points among them."""

from __future__ import annotations

import math
import operator
import os
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from . import _core, _cuda, _meshes
from ._devices import device_of
from ._error import Error
from ._frames import matrix_of
from ._points import arrays_for, in_numbers, limit_of, rows_of
from ._progress import Progress, shown
from ._values import Outputs, Points, Values
from ._with_fields import WithFields
from .typing import ArrayLike, DeviceLike, MeshLike, OutLike


class ScenePoints(Points):
    """What Scene.query() found: arrays (...), and (..., 3) of vectors, in the order of the points."""

    @property
    def is_own(self) -> npt.NDArray[np.bool_]:
        """Whether the distance is that of the union of the bodies; else the union's surface may be farther away."""
        return self._array("is_own")


class SceneSurface(NamedTuple):
    """The outer surface of the bodies of a scene: the boundary of what is inside at least one of them."""

    #: faces: within the mesh of their body; whole_faces and the like: of the faces of the bodies' own outer surfaces
    surface: _meshes.OuterSurface
    bodies: npt.NDArray[np.uint32]  #: (m,): of each face of surface.mesh

    def __repr__(self) -> str:
        return f"<clsdf.SceneSurface of {len(np.unique(self.bodies))} bodies: {self.surface!r}>"


def _numbers(what: str, values: Any, shape: tuple[int, ...] | None) -> npt.NDArray[np.float64]:
    try:
        array = np.ascontiguousarray(matrix_of(values), np.float64)
    except (TypeError, ValueError):
        raise Error(f"{what}: {repr(values)[:100]} is no array of numbers") from None
    if shape is not None and array.shape != shape:
        raise Error(f"{what} has the shape {array.shape}; expected {shape}")
    return array


def poses_of(poses: Any, name: Callable[[int], str] = "matrix {}".format) -> npt.NDArray[np.float64]:
    """Rows of rotations and translations (n, 3, 4), of poses as users give them. name: of one in a message."""
    if isinstance(poses, tuple) and len(poses) == 2:
        rotation, translation = _numbers("rotation", poses[0], None), _numbers("translation", poses[1], None)
        if rotation.ndim != 3 or rotation.shape[1:] != (3, 3) or translation.shape != (len(rotation), 3):
            raise Error(f"rotation and translation have the shapes {rotation.shape} and {translation.shape}; expected "
                        "(n, 3, 3) and (n, 3)")
        return np.concatenate([rotation, translation[:, :, None]], axis=2)
    rows = _numbers("poses", poses, None)
    if rows.ndim != 3 or rows.shape[1:] not in ((3, 4), (4, 4)):
        raise Error(f"poses has the shape {rows.shape}; expected (n, 4, 4) or (n, 3, 4), or a tuple of rotations "
                    "(n, 3, 3) and translations (n, 3)")
    if rows.shape[1] == 3:
        return rows
    wrong = np.flatnonzero((rows[:, 3] != (0, 0, 0, 1)).any(axis=1))
    if wrong.size:
        raise Error(f"poses: the last row of {name(int(wrong[0]))} is {rows[wrong[0], 3].tolist()}, not [0, 0, 0, 1]")
    return np.ascontiguousarray(rows[:, :3])


def _one_pose(pose: Any) -> npt.NDArray[np.float64] | None:
    if pose is None:
        return None
    if isinstance(pose, tuple) and len(pose) == 2:
        return poses_of((_numbers("rotation", pose[0], (3, 3))[None], _numbers("translation", pose[1], (3,))[None]))
    matrix = _numbers("pose", pose, None)
    if matrix.shape not in ((3, 4), (4, 4)):
        raise Error(f"pose has the shape {matrix.shape}; expected (4, 4) or (3, 4), or a tuple (R, t)")
    return poses_of(matrix[None], lambda _: "the pose")


def _whole(what: str, values: Any, columns: int) -> npt.NDArray[np.uint32]:
    """Numbers of points and bodies, (n,) or (n, columns)."""
    array = np.asarray(values)
    shape = "(n,)" if columns == 1 else f"(n, {columns})"
    if array.size == 0:
        array = np.empty((0,) if columns == 1 else (0, columns), np.uint32)
    if array.dtype.kind not in "iu" or array.ndim != (1 if columns == 1 else 2) or array.shape[1:] not in ((), (columns,)):
        raise Error(f"{what} has the type {array.dtype} and the shape {array.shape}; expected whole numbers {shape}")
    if array.size and not (0 <= array.min() and array.max() < 2**32):
        raise Error(f"{what} has the numbers {array.min()} to {array.max()}; they count from 0")
    return np.ascontiguousarray(array, np.uint32)


def _arrays_with_own(
    outputs: Outputs | None, out: Any, dtype: npt.DTypeLike | None, shape: tuple[int, ...]
) -> tuple[dict[str, Any], Any, dict[str, Any]]:
    """arrays_for() of outputs, that of 'is_own' as bytes, which a transform has not, and the arrays as the caller gets them."""
    own = None
    if out is None:
        asked = outputs.replace(",", " ").split() if isinstance(outputs, str) else list(outputs or ())
        own = np.empty(shape, np.bool_) if "is_own" in asked else None
        outputs = [name for name in asked if name != "is_own"]
    else:
        given = out.arrays if isinstance(out, Values) else out
        if hasattr(given, "keys") and "is_own" in given:
            own = given["is_own"]
            if not isinstance(own, np.ndarray) or own.shape != shape or not own.flags.c_contiguous:
                raise Error(f"out: the array of 'is_own' is no NumPy array of the shape {shape} in C order")
            out = {name: given[name] for name in given if name != "is_own"}
        if outputs is not None:
            raise Error("outputs= and out= exclude each other: the arrays that are given say what is computed")
    arrays, results = arrays_for(outputs, out, dtype, shape)
    if own is None:
        return arrays, None, results
    return arrays, own.reshape(-1).view(np.uint8), {**results, "is_own": own}


class Scene(WithFields):
    """Many bodies, each a mesh with its own sign rule and pose: points among them, and their fields (docs/scenes.md).

    A body is added, gets a number, counted from 0, and keeps it. Bodies may share a mesh (instances), which is prepared
    once. Nothing is prepared again when poses change. The distance is the least of the bodies' signed distances: outside
    all of them that to their union, inside the depth in the deepest body.

    field() and grid() are those of a Transform: the field has the least of the bodies' signed distances, and 'body' says
    which one. Their band is 10% if none is given: each body is computed in its own band. A sample in the depth of a body,
    beyond its band, is beyond the band of the field, whatever else is near.

    A pose is a 4 x 4 or 3 x 4 matrix, or a tuple (R, t): the body's points x are at R @ x + t. Matrices may be float32:
    each rotation is replaced by the nearest one.

    surface: 'given', or 'outer': the distances of points are those to the surface of the union of the bodies that are on,
    within overlaps, too. Each mesh is replaced by its own outer surface when it is added; an open one is refused. Fields
    are then those of outer(), which cuts faces anew when bodies have moved; 'site' and 'barycentric' are refused in them.

    device: as for Transform. kept_bytes: limit of the memory that is kept of each mesh; None: the library's default.
    Raises clsdf.Error; the scene stays as it was. Any number of threads may ask; calls that change the scene wait for
    them.
    """

    _body: _core.Bodies
    _default_band = "10%"

    def __init__(self, *, device: DeviceLike = None, kept_bytes: int | None = None, surface: str = "given") -> None:
        is_outer = _meshes.is_outer(surface)
        self._body = _core.make_bodies(device_of(device), _meshes.kept_bytes_of(kept_bytes), is_outer)

    def __repr__(self) -> str:
        return f"<clsdf.Scene: {len(self)} bodies, on {self.device.name}>"

    def __reduce__(self) -> Any:
        raise Error("a clsdf.Scene cannot be pickled or copied; add its meshes again, in each process", "unsupported")

    def __len__(self) -> int:
        return self._body.size()

    def __bool__(self) -> bool:
        return True

    @property
    def memory(self) -> tuple[int, int]:
        """Bytes that are kept of all meshes between calls: of the host, and of the device."""
        return self._body.memory

    @property
    def has_sign(self) -> bool:
        """Whether a body that is on has a sign."""
        return self._body.has_sign

    @property
    def box(self) -> npt.NDArray[np.float64]:
        """(2, 3): the lower and the upper corner of the bodies that are on, where they are."""
        return np.array(self._body.box)

    def _description(self) -> tuple[str, str, float | None]:
        return self._body.field_sign, "scene", None

    # Bodies.

    def _number(self, body: Any) -> int:
        try:
            number = operator.index(body)
        except TypeError:
            raise Error(f"body: {body!r} is no whole number") from None
        if not 0 <= number < 2**32:
            raise Error(f"there is no body {number}: the scene has {len(self)}, counted from 0")
        return number

    def add(self, mesh: MeshLike | ArrayLike, faces: ArrayLike | None = None, *, pose: Any = None, sign: str = "auto") -> int:
        """Adds a body and returns its number. mesh, faces, sign: as for Transform; 'below' is refused, whose walls do not
        turn with a body."""
        if not isinstance(sign, str):
            raise Error(f"sign: {sign!r} is no text; write 'auto', 'nonzero', 'parity', 'solid-angle' or 'none'")
        if isinstance(mesh, (str, os.PathLike)) and faces is not None:
            raise Error("the second argument is faces, which belong to vertices; write pose= for a pose")
        vertices, faces, _ = _meshes.arrays_of(mesh if faces is None else (mesh, faces))
        return self._body.add(vertices, faces, _one_pose(pose), sign)

    def add_instance(self, of: int, pose: Any = None) -> int:
        """Adds a body that has the mesh and the sign rule of another one, and returns its number."""
        return self._body.add_instance(self._number(of), _one_pose(pose))

    def set_poses(self, poses: Any, bodies: Any = None) -> None:
        """Moves all bodies, or those of the numbers `bodies`. poses: an array (n, 4, 4) or (n, 3, 4), float32 or float64,
        or a tuple of rotations (n, 3, 3) and translations (n, 3). Raises clsdf.Error (invalid_argument) that names the
        body of a matrix that is no rotation to 1e-5."""
        self._body.set_poses(poses_of(poses), None if bodies is None else _whole("bodies", bodies, 1))

    def set_positions(self, body: int, positions: Any) -> None:
        """Gives the mesh of a body, and so all its instances, new positions (n, 3) before their poses."""
        self._body.set_positions(self._number(body), _meshes.as_array(positions, np.float64))

    def set_active(self, body: int, is_active: bool = True) -> None:
        """Switches a body off, as if it were not there, or on again."""
        self._body.set_active(self._number(body), bool(is_active))

    def is_active(self, body: int) -> bool:
        """Whether a body is on."""
        return self._body.is_active(self._number(body))

    def pose(self, body: int) -> npt.NDArray[np.float64]:
        """(4, 4), with the rotation that is used."""
        matrix = np.eye(4)
        matrix[:3, :3], matrix[:3, 3] = self._body.pose(self._number(body))
        return matrix

    def sign(self, body: int) -> str:
        """The rule in use: 'nonzero', 'parity', 'solid-angle' or 'none'."""
        return self._body.sign(self._number(body))

    # Points.

    def query(
        self,
        points: ArrayLike,
        outputs: Outputs | None = None,
        *,
        within: float | None = math.inf,
        out: OutLike | None = None,
        progress: Progress = None,
        wait_for: Any = None,
        refuse_unusable_points: bool = False,
        dtype: npt.DTypeLike | None = None,
    ) -> ScenePoints:
        """The least signed distance of the bodies at points anywhere, and other outputs, in the scene's coordinates.

        outputs: those of a transform, with 'body', the body of the nearest triangle (the lowest number of several;
            clsdf.no_body beyond the limit), and 'is_own', whether the distance is that of the union. triangle and site
            are those of the body's mesh. In `out` the array of 'is_own' is bool or uint8, packed and of the host.
        points, within, out, progress, wait_for, refuse_unusable_points, dtype: as of Transform.query().
        """
        points, shape = rows_of(points)
        arrays, own, results = _arrays_with_own(outputs, out, dtype, shape)
        with shown(progress) as show:
            self._body.query(points, limit_of(within), arrays, own, show, wait_for, refuse_unusable_points)
        return ScenePoints(results if out is not None else in_numbers(results))

    def query_poses(
        self,
        points: Any,
        poses: Any,
        outputs: Outputs | None = None,
        *,
        within: float | None = math.inf,
        progress: Progress = None,
        refuse_unusable_points: bool = False,
        dtype: npt.DTypeLike | None = None,
    ) -> ScenePoints:
        """query() for many configurations of the bodies in one call. poses: an array (c, n, 4, 4) or (c, n, 3, 4), n
        poses as of set_poses() for each; the scene's own poses stay. points: (..., 3). The arrays of the result are
        (c, ...), and have the bytes of set_poses() and query()."""
        points, shape = rows_of(points)
        rows = _numbers("poses", poses, None)
        if rows.ndim != 4 or rows.shape[1] != len(self):
            raise Error(f"poses has the shape {rows.shape}; expected (c, {len(self)}, 4, 4) or (c, {len(self)}, 3, 4)")
        flat = poses_of(rows.reshape(-1, *rows.shape[2:]),
                        lambda number: f"body {number % len(self)} in configuration {number // len(self)}")
        arrays, own, results = _arrays_with_own(outputs, None, dtype, (len(rows), *shape))
        with shown(progress) as show:
            self._body.query_poses(points, flat, limit_of(within), arrays, own, show, refuse_unusable_points)
        return ScenePoints(results)

    def query_pairs(
        self,
        points: ArrayLike,
        pairs: Any,
        outputs: Outputs | None = None,
        *,
        within: float | None = math.inf,
        out: OutLike | None = None,
        progress: Progress = None,
        refuse_unusable_points: bool = False,
        dtype: npt.DTypeLike | None = None,
    ) -> Points:
        """The outputs of each pair of a point and a body, by that body alone. pairs: whole numbers (m, 2), the rows of
        points (n, 3), and bodies that are on. Other parameters: as of query()."""
        points, _ = rows_of(points)
        asked = _whole("pairs", pairs, 2)
        arrays, results = arrays_for(outputs, out, dtype, (len(asked),))
        with shown(progress) as show:
            self._body.query_pairs(points, asked, limit_of(within), arrays, show, refuse_unusable_points)
        return Points(results)

    def query_each(
        self,
        points: Any,
        outputs: Outputs | None = None,
        *,
        bodies: Any = None,
        within: float | None = math.inf,
        progress: Progress = None,
        refuse_unusable_points: bool = False,
        dtype: npt.DTypeLike | None = None,
    ) -> Points:
        """The outputs of every point by every body alone: arrays (number of bodies, ...) of points (..., 3). bodies: the
        numbers of some; None: all of them, which must be on. Other parameters: as of query()."""
        points, shape = rows_of(points)
        numbers = np.arange(len(self), dtype=np.uint32) if bodies is None else _whole("bodies", bodies, 1)
        for number in numbers:
            if number >= len(self):
                raise Error(f"bodies: there is no body {number}; the scene has {len(self)}, counted from 0")
        count = _cuda.shape_of(points)[0]
        pairs = np.empty((len(numbers), count, 2), np.uint32)
        pairs[..., 0], pairs[..., 1] = np.arange(count, dtype=np.uint32), numbers[:, None]
        arrays, results = arrays_for(outputs, None, dtype, (len(numbers), *shape))
        with shown(progress) as show:
            self._body.query_pairs(points, pairs.reshape(-1, 2), limit_of(within), arrays, show, refuse_unusable_points)
        return Points(results)

    def contains(self, points: ArrayLike) -> npt.NDArray[np.bool_]:
        """Whether points (..., 3) are inside a body: an array (...), exact. One on the surface of a body is not inside
        this one; one that is not finite is not inside."""
        points, shape = rows_of(points)
        found = np.empty(_cuda.shape_of(points)[0], np.uint8)
        self._body.contains(points, found)
        return found.view(np.bool_).reshape(shape)

    def outer(self) -> SceneSurface:
        """The outer surface of the bodies that are on, where they are: faces are cut where bodies meet, and what lies in
        another body is left out. A Transform of surface.mesh has the distance to the union, within overlaps, too, where
        the scene's is only a lower bound of the depth; clsdf.fractions(surface, ...) counts once what is in several.
        It is made anew by each call, in time that grows with the bodies' faces: for bodies at rest.

        Raises clsdf.Error: unsupported if a body has no outer surface, as an open one, which the message names;
        invalid_argument if no body is on. Uses all cores, without the GIL."""
        found, bodies = self._body.outer()
        return SceneSurface(_meshes.surface_of(found, "bodies"), bodies)

    def classify(self, boxes: Any, half_width: float) -> npt.NDArray[np.uint8]:
        """The place of each box (n, 2, 3), as numbers of clsdf.BoxPlace: INSIDE if it is inside one of the bodies,
        OUTSIDE (BEYOND if no body has a sign) if it is that of all of them. As of Transform.classify()."""
        return self._body.classify(_meshes.boxes_of(boxes), limit_of(half_width, "half_width"))

    def winding(self, points: ArrayLike) -> npt.NDArray[np.float64]:
        """The sum of the bodies' winding numbers, in their order: an array (...). As of Transform.winding()."""
        points, shape = rows_of(points)
        sums = np.empty(_cuda.shape_of(points)[0])
        self._body.winding(points, sums)
        return sums.reshape(shape)
