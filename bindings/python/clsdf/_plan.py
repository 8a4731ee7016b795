"""Boxes that are computed again and again into the memory of the device."""

from __future__ import annotations

import enum
from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any, NamedTuple

from . import _core
from ._core import Band, Grid
from ._error import Error
from ._lengths import BandLike
from ._progress import Progress, shown
from ._values import whole

if TYPE_CHECKING:
    from ._transform import Transform


class Request(NamedTuple):
    """One box of many: a grid, the band as of field(), and a dictionary of arrays by the names of outputs, which are
    written to."""

    grid: Grid
    band: BandLike
    out: dict[str, Any]


class _Prepared:
    """The common part of all plans."""

    _plan: _core.PlanOfBoxes | _core.PlanOfBricks | _core.PlanOfPoints | _core.PlanOfLinks
    _memory: Any = None  # see Transform.from_shared()

    @property
    def device_bytes(self) -> int:
        """Device memory of the plan, beside what the transform keeps."""
        return self._plan.device_bytes

    @property
    def sign(self) -> str:
        """The rule in use: 'nonzero', 'parity', 'solid-angle', 'below' or 'none'."""
        return self._plan.sign

    def _enqueued(self, queue: Any, wait_for: Iterable[Any] | None, *arrays: Any) -> Any:
        """The pyopencl.Event of a run; None if its arrays are in memory of CUDA."""
        enqueue: Any = self._plan.enqueue
        event = enqueue(queue, *arrays, None if wait_for is None else list(wait_for))
        if event == 0:
            return None
        import pyopencl  # type: ignore[import-not-found,import-untyped,unused-ignore]

        return pyopencl.Event.from_int_ptr(event, retain=False)  # takes the reference


class Plan(_Prepared):
    """What Transform.plan() made. It may outlive the transform. Threads take turns. Needs pyopencl, but for arrays in
    memory of CUDA."""

    _plan: _core.PlanOfBoxes

    def __init__(self, plan: _core.PlanOfBoxes) -> None:
        self._plan = plan

    def __repr__(self) -> str:
        return f"<clsdf.Plan: {self.device_bytes} bytes of the device, sign {self.sign}>"

    def enqueue(self, *, out: Any = None, queue: Any = None, wait_for: Iterable[Any] | None = None) -> Any:
        """Enqueues the computation of all boxes; never blocks.

        out: pyopencl arrays, or buffers, which are packed: of one grid a dictionary by names of outputs, or the array of
            the distance; of more requests a list of dictionaries. None: the arrays of the plan's requests. They may be
            arrays in memory of CUDA: a SharedArray, or tensors of torch or arrays of CuPy on the same GPU. Their streams
            are asked for at each call.
        queue: a pyopencl.CommandQueue of the device's context; None: the device's own. wait_for: pyopencl events.

        Returns the pyopencl.Event of the end, and the arrays must outlive the run. With arrays in memory of CUDA it
        returns None: the run follows the work of their streams, and what their streams do next follows the run. If the
        driver has no semaphores for that, the call waits. Raises clsdf.Error: invalid_argument for a plan of a grid
        without `out`, for arrays of another shape, context or device; unsupported for other types.
        """
        targets = None
        if out is not None:
            targets = [_arrays(one) for one in out] if isinstance(out, (list, tuple)) else [_arrays(out)]
        return self._enqueued(queue, wait_for, targets)

    def update(
        self,
        transform: Transform,
        *,
        grids: Iterable[Grid] | None = None,
        requests: Iterable[Request] | None = None,
        progress: Progress = None,
    ) -> None:
        """Prepares the next runs for the present positions of the transform: of the same boxes, of other grids whose
        samples fit the arrays, or of other requests. Blocks."""
        if grids is not None and requests is not None:
            raise Error("grids= and requests= exclude each other: a Request has its grid")
        with shown(progress) as show:
            if requests is not None:
                self._plan.update_requests(transform._body, transform._requests(requests), show)
            else:
                self._plan.update(transform._body, None if grids is None else list(grids), show)
            self._memory = transform._memory


class SparsePlan(_Prepared):
    """What Transform.sparse_plan() made: a sparse field that stays in memory of the device. It may outlive the transform.
    Threads take turns. Needs pyopencl, but for arrays in memory of CUDA."""

    _plan: _core.PlanOfBricks

    def __init__(self, plan: _core.PlanOfBricks) -> None:
        self._plan = plan

    def __repr__(self) -> str:
        bricks, runs = self.room
        return f"<clsdf.SparsePlan: room for {bricks} bricks and {runs} runs, sign {self.sign}>"

    @property
    def room(self) -> tuple[int, int]:
        """How many bricks and runs of bricks inside a run has room for."""
        return self._plan.room

    @property
    def grid(self) -> Grid:
        return self._plan.grid

    @property
    def band(self) -> Band:
        return self._plan.band

    def enqueue(self, *, out: Mapping[str, Any], queue: Any = None, wait_for: Iterable[Any] | None = None) -> Any:
        """Enqueues the computation; never blocks and reads nothing back.

        out: arrays of pyopencl, or buffers, which are packed, or arrays in memory of CUDA (see Plan.enqueue()):
            'counts': int64, (3,): the field's bricks, its runs, and 1 if the arrays hold them all. 0: they had too little
                room, and are undefined.
            'bricks': int64, (room[0], 3), and 'inside': int64, (room[1], 4), as SparseField has them.
            'distance' and the other outputs of the plan: (room[0], 8, 8, 8), vectors (room[0], 8, 8, 8, 3).
        queue, wait_for and the result: as of Plan.enqueue(). The arrays must outlive the run.
        """
        return self._enqueued(queue, wait_for, dict(out))

    def update(
        self,
        transform: Transform,
        *,
        grid: Grid | None = None,
        band: BandLike | None = None,
        room: tuple[int, int] | None = None,
        progress: Progress = None,
    ) -> None:
        """Prepares the next runs for the present positions of the transform: of the same field, or of another grid or band,
        or with other room. Blocks. A width as the band has exact signs if the plan's band has them; a Band says so itself."""
        with shown(progress) as show:
            if grid is None and band is None and room is None:
                self._plan.update(transform._body, show)
                self._memory = transform._memory
                return
            own_grid, own_band = transform._grid_and_band(
                self.grid if grid is None else grid,
                self.band if band is None else band,
                exact_signs=self.band.exact_signs and not isinstance(band, Band),
            )
            own_room = self.room if room is None else room_of(room)
            self._plan.update_field(transform._body, own_grid, own_band, self._plan.outputs, own_room, show)
            self._memory = transform._memory


class PointPlan(_Prepared):
    """What Transform.plan_points() made. It may outlive the transform. Threads take turns. Needs pyopencl, but for arrays
    in memory of CUDA."""

    _plan: _core.PlanOfPoints

    def __init__(self, plan: _core.PlanOfPoints) -> None:
        self._plan = plan

    def __repr__(self) -> str:
        return f"<clsdf.PointPlan: {self.count} points, {self.device_bytes} bytes of the device, sign {self.sign}>"

    @property
    def count(self) -> int:
        """The most points of a run."""
        return self._plan.count

    def enqueue(
        self, points: Any, *, out: Any, status: Any = None, queue: Any = None, wait_for: Iterable[Any] | None = None
    ) -> Any:
        """Enqueues the search for points; never blocks, and nothing comes to the host.

        points: a pyopencl array (n, 3) of float32 or float64, of any strides, with at most `count` points. out: pyopencl
            arrays (n,), and (n, 3) of vectors: a dictionary by names of outputs, or the array of the distance. Or arrays
            in memory of CUDA, as of Plan.enqueue(). status: an array (n,) of uint8, whose values are PointStatus: what
            became of each point.
        queue: a pyopencl.CommandQueue of the device's context; None: the device's own. wait_for: pyopencl events.

        Returns the pyopencl.Event of the end, and the arrays must outlive the run; None with arrays in memory of CUDA,
        whose streams follow the run. Raises clsdf.Error: invalid_argument for too many points, for outputs that the plan
        was not made with, for arrays that overlap or are of another shape, context or device; unsupported for other
        types.
        """
        return self._enqueued(queue, wait_for, points, _arrays(out), status)

    def update(self, transform: Transform, *, progress: Progress = None) -> None:
        """Prepares the next runs for the present positions of the transform. Blocks."""
        with shown(progress) as show:
            self._plan.update(transform._body, show)
            self._memory = transform._memory


class LinkPlan(_Prepared):
    """What Transform.plan_links() made. It may outlive the transform. Threads take turns. Needs pyopencl, but for arrays in
    memory of CUDA."""

    _plan: _core.PlanOfLinks

    def __init__(self, plan: _core.PlanOfLinks) -> None:
        self._plan = plan

    def __repr__(self) -> str:
        return f"<clsdf.LinkPlan: room for {self.room} links, {self.device_bytes} bytes of the device, sign {self.sign}>"

    @property
    def room(self) -> int:
        """The most rows of a run."""
        return self._plan.room

    @property
    def grid(self) -> Grid:
        return self._plan.grid

    @property
    def device_bytes(self) -> int:
        """Device memory of the plan."""
        return self._plan.device_bytes

    def enqueue(self, *, out: Mapping[str, Any], queue: Any = None, wait_for: Iterable[Any] | None = None) -> Any:
        """Enqueues copies of the links; never blocks and reads nothing back.

        out: arrays of pyopencl, which are packed, or arrays in memory of CUDA (see Plan.enqueue()):
            'count': int64, (2,): the number of links, and 1 if the arrays hold them all. 0: there is too little room, and
                rows and 'dense' are as before.
            'samples': int32, (room, 3); 'directions' and 'flags': uint8; 'q': float64 or float32; 'triangles' and
                'counts': uint32 or int32, (room,), as Links has them. Rows beyond the number of links stay.
            'inside': uint8, of the grid's shape. 'dense': float64 or float32, (directions, *grid.shape): q, or -1.
        queue, wait_for and the result: as of Plan.enqueue(). The arrays must outlive the run.
        """
        return self._enqueued(queue, wait_for, dict(out))

    def update(
        self, transform: Transform, *, grid: Grid | None = None, room: int | None = None, progress: Progress = None
    ) -> None:
        """Prepares the next runs for the present positions of the transform: of the same grid and room, or of others.
        Blocks. After an error the plan is as it was."""
        with shown(progress) as show:
            own_grid = self.grid if grid is None else grid
            rows = self.room if room is None else whole("room", room, "links", least=0)
            self._plan.update(transform._body, own_grid, rows, show)
            self._memory = transform._memory


class PointStatus(enum.IntEnum):
    """The outcome of a point in a PointPlan's run."""

    FOUND = 0
    #: the distance is NaN; there is no triangle
    NOT_FINITE = 1
    #: the distance is `within`, or NaN without a limit; there is no triangle
    TOO_FAR = 2
    #: exact arithmetic did not suffice for the sign: the distance is NaN, and there is no triangle. Only some points may be
    #: left so that have a coordinate which is not zero and smaller than 2^-300 of the mesh. query() has their sign.
    SIGN_OPEN = 3


def room_of(room: Any) -> tuple[int, int]:
    """Bricks and runs of a sparse plan."""
    try:
        bricks, runs = room
    except (TypeError, ValueError):
        raise Error(f"room: {room!r} is not two whole numbers, of bricks and of runs") from None
    return whole("room", bricks, "bricks", least=0), whole("room", runs, "runs", least=0)


def _arrays(out: Any) -> dict[str, Any]:
    return dict(out) if isinstance(out, Mapping) else {"distance": out}
