"""The exact distance to a mesh: on grids, on many boxes, and at points."""

from __future__ import annotations

import enum
import math
import os
import threading
from collections.abc import Iterable, Iterator, Sequence
from typing import Any, NamedTuple, TypeVar

import numpy as np
import numpy.typing as npt

from . import _core, _cuda, _images, _meshes, _sparse
from ._core import Device, Grid, Topology
from ._devices import device_of
from ._error import Error
from ._frames import Motion, frame_of, into_frame, motion_of, out_of_frame, vectors
from ._lengths import BandLike, LengthLike, parse_length
from ._points import arrays_for, by_limit, in_floats, in_numbers, limit_each, limit_of, limits_of, on_host, on_surface
from ._points import pairs_of, rows_of
from ._progress import Progress, shown
from ._values import Blocks, Outputs, Points, given, new_samples, real_of, wanted, whole
from ._field import Field
from ._links import Crossings, DirectionsLike, Links, directions_of, grid_of, is_in_floats, is_of_faces
from ._plan import LinkPlan, Plan, PointPlan, Request, SparsePlan, room_of
from ._sparse import SparseField
from ._with_fields import WithFields
from .typing import ArrayLike, DeviceLike, FrameLike, MeshLike, OutLike, RotationLike


class Region(NamedTuple):
    """A box of the domain, and the largest half width and spacing that are asked for in it (spacing 0: points and boxes
    alone), in the mesh's units. For restrict_to()."""

    lower: Sequence[float]
    upper: Sequence[float]
    half_width: float
    spacing: float = 0


class Rays(NamedTuple):
    """Where rays meet the surface, from rays()."""

    #: In lengths of the direction; infinity where nothing more is met, NaN for a ray that is not usable.
    t: Any
    #: The lowest triangle at that t, or clsdf.no_triangle.
    triangle: Any
    #: All hits up to the limit; None unless asked for.
    counts: Any = None

    def __repr__(self) -> str:
        shape = np.shape(self.t)
        if not shape:
            return f"<clsdf.Rays: t {self.t:.6g}, triangle {self.triangle}>"
        return f"<clsdf.Rays: {np.count_nonzero(np.isfinite(self.t))} hits in arrays of shape {shape}>"


class BoxPlace(enum.IntEnum):
    """The position of a box relative to the mesh, from classify()."""

    WITHIN = 0  #: the surface may be within the half width of a point of the box
    INSIDE = 1  #: the surface is farther from every point of the box, and all of them are inside
    OUTSIDE = 2  #: the same, and all of them are outside
    BEYOND = 3  #: the same, of a mesh that has no sign


class MadeOf(NamedTuple):
    """The arguments of a transform, to make it again elsewhere."""

    vertices: Any  #: None, like the faces, of a part and of shared memory
    faces: Any
    sign: str  #: the rule that was asked for
    kept_bytes: int | None
    floor: float | None
    surface: str


AnyPlan = TypeVar("AnyPlan", Plan, SparsePlan, PointPlan, LinkPlan)

#: Points that the calling thread looks up by itself, without a program of the device.
_few = 96


def _number_or_array(array: npt.NDArray[Any]) -> Any:
    """Of no axes: the number."""
    return array[()]


def _plain(region: Any) -> tuple[tuple[float, ...], tuple[float, ...], float, float]:
    """The numbers of a Region."""
    if not isinstance(region, Region):
        raise Error(f"regions: {region!r} is no clsdf.Region; write clsdf.Region(lower, upper, half_width, spacing)")
    lower = tuple(vectors("lower", region.lower, (3,)).tolist())
    upper = tuple(vectors("upper", region.upper, (3,)).tolist())
    try:
        return lower, upper, float(region.half_width), float(region.spacing)
    except (TypeError, ValueError):
        raise Error(f"regions: {region!r} has a half width or a spacing that is no number") from None


class Transform(WithFields):
    """The exact distance to a triangle mesh, negative inside.

    mesh: a path (.off, .obj, .stl, .ply); vertices and faces, as a tuple or as two arguments, arrays (n, 3) of float32
        or float64 and (m, 3) of int32, int64, uint32 or uint64; or a mesh of trimesh, pyvista, meshio or open3d. Faces
        are counter-clockwise seen from outside. The mesh is copied once: the arrays may change afterwards.
    device: None (clsdf.Device.automatic()), a clsdf.Device, an index or a part of a device's name, or a
        pyopencl.CommandQueue.
    sign: 'auto', 'nonzero', 'parity', 'solid-angle', 'below' or 'none'. With 'auto' an open mesh gets 'solid-angle' if
        its winding number is clear, else no sign; a MeshWarning says which. 'below' is for terrains: walls down from the
        rim and a floor close them for the sign.
    floor: of the rule 'below', which needs one: its z, below all vertices, also when they move.
    kept_bytes: limit of the device memory that is kept between calls; None: the library's default.
    surface: 'given', all faces, or 'outer', the outer surface of overlapping parts, as clsdf.outer() makes it. Then
        results tell the faces as given that the nearest triangles are parts of.

    Raises clsdf.Error: invalid_mesh names the row and the value; also unreadable_input, no_device, device_failure.

    Any number of threads may use a transform; calls that compute run side by side without the GIL, and those that set
    positions wait for them. Ctrl-C ends a call. Calls may take `progress`, True or a function of the stage
    ('compiling', 'testing', 'computing') and its fraction (None: a line on stderr if the first use of the device compiles for
    more than 2 seconds; False: without it), and `wait_for`, pyopencl events after which arrays of the
    device are used. The function must not make or use a transform or a plan of the device; nor must a handler of
    signals that comes during the call.
    """

    _body: _core.Body

    def __init__(
        self,
        mesh: MeshLike | ArrayLike,
        faces: ArrayLike | None = None,
        *,
        device: DeviceLike = None,
        sign: str = "auto",
        kept_bytes: int | None = None,
        floor: float | None = None,
        surface: str = "given",
    ) -> None:
        is_outer = _meshes.is_outer(surface)
        if floor is not None:
            try:
                floor = float(floor)
            except (TypeError, ValueError):
                raise Error(f"floor: {floor!r} is no number; write the z of the floor, or None") from None
        kept_bytes = _meshes.kept_bytes_of(kept_bytes)
        if not isinstance(sign, str):
            raise Error(f"sign: {sign!r} is no text; write 'auto', 'nonzero', 'parity', 'solid-angle', 'below' or 'none'")
        is_own = faces is None and isinstance(mesh, (str, os.PathLike))
        vertices, faces, name = _meshes.arrays_of(mesh if faces is None else (mesh, faces))
        body = _core.make_body(device_of(device), vertices, faces, sign, kept_bytes, floor, is_outer)
        if not is_own:
            vertices, faces = _meshes.own_copy(vertices, body.device), _meshes.own_copy(faces, body.device)
        self._keep(body, name, MadeOf(vertices, faces, sign, kept_bytes, floor, surface))

    def _keep(self, body: _core.Body, mesh_name: str, made_of: MadeOf) -> None:
        self._body, self.mesh_name, self._made_of = body, mesh_name, made_of
        self._positions: Any = None
        self._motion: Any = None
        self._regions: Any = None
        self._memory: Any = None  # of from_shared(): what the transform and its plans read
        self._moves = threading.RLock()  # a handler of signals that moves the body gets the extension's error

    @classmethod
    def _without_mesh(cls, body: _core.Body, kept_bytes: int | None) -> Transform:
        """The transform of a body that has a name, a rule and a floor of its own."""
        made = cls.__new__(cls)
        made._keep(body, body.mesh_name, MadeOf(None, None, body.sign, kept_bytes, body.floor, "given"))
        return made

    # Copies.

    def __reduce__(self) -> tuple[Any, ...]:
        """The mesh's arrays, the present positions, the options, and the device by its name and limits, on which
        unpickling makes the transform again. Of a part its bytes."""
        if self._memory is not None:
            raise Error(
                "a transform of shared memory is neither copied nor pickled; call clsdf.Transform.from_shared() with the "
                "memory again, in another process with memory of the same name",
                "unsupported",
            )
        if self._made_of.vertices is None:
            return _part_again, (self.part_bytes(), self.device, self._made_of.kept_bytes, self._regions)
        with self._moves:
            return _made_again, (self.device, self.mesh_name, self._made_of, self._positions, self._motion, self._regions)

    def __copy__(self) -> Transform:
        """A transform of the same mesh at its present positions, on the same device."""
        make, of = self.__reduce__()
        return make(*of)  # type: ignore[no-any-return]

    def __deepcopy__(self, memo: dict[int, Any]) -> Transform:
        return self.__copy__()

    def __repr__(self) -> str:
        return f"<clsdf.Transform: {self.mesh_name}, sign {self.sign}, on {self.device.name}>"

    # The mesh.

    @property
    def box(self) -> npt.NDArray[np.float64]:
        """(2, 3): the lower and the upper corner of the vertices in use, at their present positions."""
        return np.array(self._body.box)

    @property
    def bounds(self) -> npt.NDArray[np.float64]:
        """(2, 3): `box`, by the name that trimesh has for it."""
        return self.box

    @property
    def volume(self) -> float:
        """What the faces enclose, at their present positions, in cubed units, rounded to about 1e-13 of the box. Of a mesh
        whose faces are balanced as they are, each part by its winding number: the overlap of two parts counts twice, and
        a part that is inside out counts negative. With surface='outer', with the rule 'parity', and of a mesh of which
        faces are joined, turned around or left out for the sign, that of clsdf.outer(), which takes its time. Raises
        clsdf.Error (unsupported) for a mesh that is open."""
        topology = self.topology  # of the surface that decides the sign: these are the faces that it has not as given
        others = topology.uncounted_faces + topology.reoriented_faces + topology.sheet_faces + topology.double_sided_faces + topology.detail_faces
        if topology.balanced and others == 0 and self.sign in ("nonzero", "none") and self._made_of.surface == "given":
            return _meshes.volume_of(self.vertices, self.faces)
        if self.sign not in ("nonzero", "parity"):
            raise Error(f"{self.mesh_name} has the sign rule {self.sign}, and an open surface encloses no volume; close it",
                        "unsupported")
        return _meshes.outer((self.vertices, self.faces), self.sign).volume

    @property
    def area(self) -> float:
        """Of the faces as given, at their present positions, in squared units, also of those inside other parts."""
        return _meshes.area_of(self.vertices, self.faces)

    @property
    def floor(self) -> float | None:
        """Of the sign rule 'below': z of the floor."""
        return self._made_of.floor

    @property
    def topology(self) -> Topology:
        """Whether the mesh is closed, balanced or inside out, and its numbers of open edges and others."""
        return self._body.topology

    @property
    def sign(self) -> str:
        """The rule in use: 'nonzero', 'parity', 'solid-angle', 'below' or 'none'."""
        return self._body.sign

    @property
    def memory(self) -> tuple[int, int]:
        """Bytes that are kept between calls: of the host, and of the device."""
        return self._body.memory

    @property
    def shared_memory(self) -> tuple[int, int]:
        """Bytes that the device keeps for all its transforms: pinned memory of the host, and memory of the device that
        no transform uses. Device.release_memory() gives them back."""
        return self._body.shared_memory

    def set_positions(self, positions: ArrayLike, *, wait_for: Any = None) -> None:
        """Gives the same faces new positions: an array (n, 3), one row for each vertex of the mesh, or, of a part with a
        margin, for each of part_vertices. What follows from the faces stays. Raises clsdf.Error: invalid_argument for
        another number of rows and for a vertex beyond the margin, invalid_mesh for a row that is not finite; the
        positions are those of before then."""
        positions = _meshes.as_array(positions, np.float64)
        _meshes.refuse_graph("positions", positions, "clsdf.torch.signed_distance(body, points, vertices) gives it, or ")
        with self._moves:
            self._body.set_positions(positions, wait_for)
            if self._made_of.vertices is not None:
                self._positions, self._motion = _meshes.own_copy(positions, self.device), None

    def set_motion(self, rotation: RotationLike, translation: ArrayLike | None = None) -> Motion:
        """Puts the vertices at rotation @ x + translation. x are the positions of the mesh that the transform was made
        from, so errors do not add up. For a body that is rigid, query(points, frame=(rotation, translation)) is much
        cheaper, since it prepares nothing.

        rotation: 3 x 3, or a 4 x 4 pose with the last row 0 0 0 1 and no translation beside it. A matrix that was
        rounded to float32 is made a rotation again, the same on every machine.

        Returns the motion in use: the rotation and the translation, float64. Raises clsdf.Error if the matrix is no
        rotation to 1e-5, a reflection for instance.
        """
        motion = motion_of("rotation", rotation, translation)
        with self._moves:
            self._body.set_motion(motion[0].tolist(), motion[1].tolist())
            self._positions, self._motion = None, motion
        return motion[0].copy(), motion[1].copy()

    @property
    def faces(self) -> npt.NDArray[Any]:
        """(m, 3): the faces that the transform was made of, read-only."""
        self._check_mesh()
        return self._made_of.faces  # type: ignore[no-any-return]

    @property
    def vertices(self) -> npt.NDArray[Any]:
        """(n, 3): the vertices that the transform was made of, at their present positions, read-only."""
        self._check_mesh()
        with self._moves:
            first, positions, motion = self._made_of.vertices, self._positions, self._motion
        if motion is None:
            return first if positions is None else positions  # type: ignore[no-any-return]
        moved = _core.moved(np.ascontiguousarray(first, np.float64), *motion)
        moved.flags.writeable = False
        return moved

    def _check_mesh(self) -> None:
        if self._made_of.vertices is None:
            what = "a part, made by restrict_to() or from_part(),"
            if self._memory is not None:
                what = "a transform of shared memory, made by from_shared(),"
            raise Error(f"{what} has no mesh; ask the whole transform", "unsupported")

    def sample(self, n: int, within: float = 0.0, seed: int | None = None) -> npt.NDArray[np.float64]:
        """Points (n, 3), float64, on the surface, as dense on large faces as on small ones; with `within` each is moved
        in a random direction by up to that length, so it is at most that far from the surface. seed: of NumPy's
        default_rng(); the same seed gives the same points. query() has their distances. With surface='outer' each call
        makes the outer surface anew; sampling clsdf.outer(mesh).mesh does not."""
        count, radius = whole("n", n, "points"), limit_of(within)
        if count < 0 or not 0 <= radius < math.inf:
            raise Error(f"sample takes a number of points and a length, each 0 or more; not {n!r} and {within!r}")
        vertices, faces = self.vertices, self.faces
        if self._made_of.surface == "outer":
            vertices, faces, *_ = _core.outer(vertices, faces, self._made_of.sign, is_silent=True)
        return on_surface(vertices, faces, count, radius, seed)

    # Grids.

    def _description(self) -> tuple[str, str, float | None]:
        return self.sign, self.mesh_name, self.floor

    def _requests(self, requests: Iterable[Request]) -> list[Any]:
        """Those whose band is a length or a text get a Band. A dictionary of arrays is copied: a plan's arrays stay
        even if the caller's dictionary changes. All else is for the extension to refuse."""
        return [
            (
                request[0],
                self._band_on(request[0], request[1]),
                dict(request[2]) if isinstance(request[2], dict) else request[2],
            )
            if isinstance(request, tuple) and len(request) == 3 and isinstance(request[0], Grid)
            else request
            for request in requests
        ]

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
        geometry = _images.geometry_of(image)
        if self._memory is not None:
            self._check_mesh()
        if self.sign == "below" or self._regions is not None or self._made_of.vertices is None:
            raise Error("image: a terrain, whose walls are along z, and a restricted transform have fields of grids alone",
                        "unsupported")
        # The first positions decide what the sign counts.
        vertices, mirrored = _images.in_frame(geometry, self._made_of.vertices)
        body = _made_again(self.device, self.mesh_name, self._made_of._replace(vertices=vertices))
        if self._positions is not None or self._motion is not None:
            body.set_positions(_images.in_frame(geometry, self.vertices)[0])
        grid, own_band = body._grid_and_band(geometry.grid, self._in_units(band), exact_signs=exact_signs)
        arrays = new_samples(wanted(outputs or ()), grid.shape, dtype)
        # A mirrored image has its samples along x in the reverse order.
        views = arrays if mirrored is None else {name: array[:, :, ::-1] for name, array in arrays.items()}
        self._warn_of_narrow(grid, own_band)
        body._computed(grid, own_band, views, positive_inside, progress)
        _images.finish(geometry, arrays, mirrored)
        return Field(grid, own_band, self.sign, self.mesh_name, arrays, positive_inside, image=geometry)

    def _in_units(self, band: BandLike) -> BandLike:
        """A part of the mesh's box as a length: a mesh in another frame has another box."""
        if isinstance(band, (tuple, list)):
            return tuple(self._in_units(width) for width in band)  # type: ignore[return-value]
        if isinstance(band, str) and band.endswith("%"):
            return parse_length("band", band).resolve(1.0, self._longest_side())
        return band

    def fields(
        self,
        grids: Iterable[Grid],
        *,
        band: BandLike = "full",
        outputs: Outputs = "distance",
        exact_signs: bool = False,
        positive_inside: bool = False,
        progress: Progress = None,
    ) -> list[Field]:
        """The fields of many grids of any lattices, in one call, which is cheaper than one call each; each has the
        bytes of a call of its own. Options: as of field()."""
        if isinstance(grids, Grid):
            raise Error("grids: one clsdf.Grid is given; pass a list of grids, or use field() for one")
        fields = []
        outputs = wanted(outputs)
        for grid in grids:
            grid, own_band = self._grid_and_band(grid, band, exact_signs=exact_signs)
            arrays = new_samples(outputs, grid.shape)
            fields.append(Field(grid, own_band, self.sign, self.mesh_name, arrays, positive_inside, self.floor))
            if positive_inside:
                self._check_negatable(arrays, own_band)
        if fields:
            coarsest = max(fields, key=lambda field: field.grid.voxel)
            self._warn_of_narrow(coarsest.grid, coarsest.band)
        self.compute([Request(field.grid, field.band, field.arrays) for field in fields], progress=progress)
        for field in fields if positive_inside else ():
            _core.negate(field.arrays)
        return fields

    def compute(self, requests: Iterable[Request], *, progress: Progress = None, wait_for: Any = None) -> None:
        """Computes many boxes into your arrays in one call, each with its own grid, band and outputs. If one is
        refused, nothing is computed, and the error names its index."""
        with self._turn(progress, "boxes") as show:
            self._body.compute_many(self._requests(requests), show, wait_for)

    def blocks(
        self,
        lattice: Grid,
        first: npt.ArrayLike,
        size: Sequence[int],
        *,
        band: BandLike = "full",
        outputs: Outputs | None = None,
        exact_signs: bool = False,
        out: OutLike | None = None,
        progress: Progress = None,
        wait_for: Any = None,
    ) -> Blocks:
        """Equal blocks of one lattice in one call: the leaves of an octree, the patches of a level.

        lattice: a Grid, of which origin and spacing count. first: (n, 3) integers, the first sample (i, j, k) of each
        block on the lattice. size: samples (nx, ny, nz) of each block. band, outputs, out: as of field(), with arrays
        of the shape (n, nz, ny, nx).
        """
        _, own_band = self._grid_and_band(lattice, band, exact_signs=exact_signs)
        rows = np.asarray(first)
        if rows.size == 0:
            rows = np.zeros((0, 3), np.int64)
        if rows.dtype.kind not in "iu" or rows.ndim != 2 or rows.shape[1] != 3:
            raise Error(f"first has the shape {rows.shape} and the type {rows.dtype}; expected whole numbers (n, 3)")
        corners = [tuple(row) for row in rows.tolist()]
        if np.shape(size) != (3,):
            raise Error(f"size: {size!r} is not three numbers of samples (nx, ny, nz)")
        shape = (len(corners), *reversed([whole("size", side) for side in size]))
        arrays = new_samples(wanted(outputs or ()), shape) if out is None else given(out, outputs)
        with self._turn(progress, "blocks", arrays) as show:
            self._body.compute_blocks(lattice, own_band, size, corners, arrays, show, wait_for)
        return Blocks(arrays)

    def slabs(
        self,
        grid: Grid | None = None,
        *,
        resolution: int | None = None,
        spacing: float | Sequence[float] | None = None,
        margin: LengthLike | None = None,
        cubic: bool = False,
        cell_centred: bool = False,
        band: BandLike = "full",
        outputs: Outputs = "distance",
        exact_signs: bool = False,
        positive_inside: bool = False,
    ) -> Iterator[Field]:
        """A field of any size as an iterator of its slabs: Fields of whole slices, in the order of z, at most about 16
        million samples at a time. Options: as of field(). Each slab is computed when it is asked for; the bytes are
        those of the whole."""
        all_of_it, own_band = self._grid_and_band(grid, band, resolution, spacing, margin, cubic, cell_centred, exact_signs)
        outputs = wanted(outputs)
        self._warn_of_narrow(all_of_it, own_band)
        return (
            self._computed(part, own_band, new_samples(outputs, part.shape), positive_inside)
            for part in _core.slabs_of(all_of_it)
        )

    def sparse(
        self,
        grid: Grid | None = None,
        *,
        resolution: int | None = None,
        spacing: float | Sequence[float] | None = None,
        margin: LengthLike | None = None,
        cubic: bool = False,
        cell_centred: bool = False,
        band: BandLike = "3v",
        outputs: Outputs = "distance",
        exact_signs: bool = False,
        positive_inside: bool = False,
        progress: Progress = None,
        wait_for: Any = None,
    ) -> SparseField:
        """Computes the bricks (8 x 8 x 8 samples) near the surface, and the sign of the rest. Neither time nor memory
        grows with the samples far from the surface. Every value has the bits of the dense field's.

        Options: as of field(), with a band of three voxels. It must have an end; a field of signs alone is dense. A
        restricted transform needs regions that hold whole bricks: the box of grid.in_whole_bricks().
        """
        grid, own_band = self._grid_and_band(grid, band, resolution, spacing, margin, cubic, cell_centred, exact_signs)
        names = wanted(outputs)
        if positive_inside:
            self._check_negatable({}, own_band)
        self._warn_of_narrow(grid, own_band)
        with self._turn(progress, "sparse", names) as show:
            found = _core.compute_sparse(self._body, grid, own_band, names, show, wait_for)
        return _sparse.made(grid, own_band, self.sign, self.mesh_name, names, found, positive_inside, self.floor)

    def sparse_fields(
        self,
        grids: Iterable[Grid],
        *,
        band: BandLike = "3v",
        outputs: Outputs = "distance",
        exact_signs: bool = False,
        positive_inside: bool = False,
        progress: Progress = None,
    ) -> list[SparseField]:
        """The sparse fields of many grids of any lattices, in one call, which is cheaper than one call each; each has
        the bytes of a call of its own. Options: as of sparse()."""
        if isinstance(grids, Grid):
            raise Error("grids: one clsdf.Grid is given; pass a list of grids, or use sparse() for one")
        requests = [self._grid_and_band(grid, band, exact_signs=exact_signs) for grid in grids]
        names = wanted(outputs)
        for _, own_band in requests if positive_inside else ():
            self._check_negatable({}, own_band)
        if requests:
            self._warn_of_narrow(*max(requests, key=lambda request: request[0].voxel))
        with self._turn(progress, "sparse", names) as show:
            all_found = _core.compute_sparse_many(self._body, requests, names, show)
        return [
            _sparse.made(grid, own_band, self.sign, self.mesh_name, names, found, positive_inside, self.floor)
            for (grid, own_band), found in zip(requests, all_found)
        ]

    def write_sparse(
        self,
        path: str | os.PathLike[str],
        grid: Grid | None = None,
        *,
        resolution: int | None = None,
        spacing: float | Sequence[float] | None = None,
        margin: LengthLike | None = None,
        cubic: bool = False,
        cell_centred: bool = False,
        band: BandLike = "3v",
        outputs: Outputs = "distance",
        exact_signs: bool = False,
        progress: Progress = None,
    ) -> None:
        """Computes a sparse field of any size into a .nvdb, .npy, .h5 or, if OpenVDB is built in, .vdb: a few layers of
        bricks are in memory at a time (a .vdb keeps the bricks). The file is that of sparse().write(path). Options: as
        of sparse(). Raises clsdf.Error as both do; no file stays then."""
        grid, own_band = self._grid_and_band(grid, band, resolution, spacing, margin, cubic, cell_centred, exact_signs)
        self._warn_of_narrow(grid, own_band)
        with self._turn(progress, "sparse", wanted(outputs)) as show:
            _core.compute_sparse_file(
                self._body, os.fsdecode(path), grid, own_band, wanted(outputs), self.sign, self.mesh_name, show, self.floor
            )

    def compile(
        self,
        grid: Grid,
        *,
        band: BandLike = "full",
        outputs: Outputs = "distance",
        exact_signs: bool = False,
        progress: Progress = None,
    ) -> None:
        """Builds and tests the programs that such a field needs. Calls do it by themselves; this is to choose when."""
        grid, own_band = self._grid_and_band(grid, band, exact_signs=exact_signs)
        with self._turn(progress, "field", wanted(outputs)) as show:
            self._body.compile(grid, own_band, wanted(outputs), show)

    # Points and boxes.

    def query(
        self,
        points: ArrayLike,
        outputs: Outputs | None = None,
        *,
        within: float | npt.ArrayLike | None = math.inf,
        out: OutLike | None = None,
        positive_inside: bool = False,
        progress: Progress = None,
        wait_for: Any = None,
        refuse_unusable_points: bool = False,
        frame: FrameLike | None = None,
        dtype: npt.DTypeLike | None = None,
    ) -> Points:
        """The exact signed distance at points anywhere, and other outputs.

        points: an array (n, 3) or (..., 3), float32 or float64, any strides; or one point (3,), whose results are
            numbers and vectors (3,); [] is no point. Results have the shape (...), and (..., 3) of vectors. outputs: as
            of field(). within: limits the search, in the mesh's units, which makes it cheaper (None: no limit); a
            farther point has that limit as its distance, with its sign, and no triangle. An array (...) has a limit for
            each point, for arrays of the host: the least distance of several bodies so far, for instance.
        out: arrays (n,), and (n, 3) of vectors, to write to, as of field(). positive_inside: as of field(). dtype:
            "float64" for distance, gradient, barycentric and offset in double, instead of `out`.
        frame: the motion (R, t), or the 4 x 4 pose, of a rigid body whose mesh stays as it is: the points, and the
            vectors of the results, are those of the world in which the body's point x is at R @ x + t. This costs
            next to nothing, unlike set_motion(). The matrix is taken as set_motion() takes it.

        The sign is exact at the given doubles; a point on the surface has the distance +0. A point that is not finite
        gets the distance NaN and no triangle; a finite one more than 1e14 voxels from the mesh (1/256 of its longest
        side) gets `within` if that is finite, else NaN. One MeshWarning has their number; with refuse_unusable_points
        they raise clsdf.Error (invalid_argument) that names the row. Raises clsdf.Error for arrays as of field().
        """
        points, shape = rows_of(points)
        limit = limits_of(within, shape)
        motion = None
        if frame is not None:
            motion = frame_of(frame)
            points = into_frame(points, *motion)
        arrays, results = arrays_for(outputs, out, dtype, shape)
        if out is not None and motion is not None and not all(isinstance(array, np.ndarray) for array in arrays.values()):
            raise Error("frame: the arrays of out= are not NumPy's, in which the results are turned", "unsupported")
        if positive_inside:
            self._check_negatable(arrays)
        if progress is None and isinstance(limit, float) and math.prod(shape) <= _few:
            self._body.query(points, limit, arrays, None, wait_for, refuse_unusable_points)
        else:
            groups = ((points, limit, arrays),) if isinstance(limit, float) else self._groups(points, limit, arrays)
            with self._turn(progress, "points", arrays) as show:
                for some, most, found in groups:
                    self._body.query(some, most, found, show, wait_for, refuse_unusable_points)
        if positive_inside:
            _core.negate(arrays)
        if motion is not None:
            out_of_frame(arrays, *motion)
        return Points(results if out is not None else in_numbers(results))

    def _groups(
        self, points: Any, limits: npt.NDArray[np.float64], arrays: dict[str, Any]
    ) -> Iterator[tuple[Any, float, dict[str, Any]]]:
        """Points, limit and arrays of calls, one for all points of about the same limit, whose results go to `arrays`."""
        given_arrays = (points, *arrays.values())
        if any(hasattr(array, "base_data") or _cuda.is_in_cuda(array) for array in given_arrays):
            raise Error("within: an array needs points and out= of the host; copy them, or give one number", "unsupported")
        points, arrays = on_host(points), {name: on_host(array) for name, array in arrays.items()}
        for rows in by_limit(points, limits, self._longest_side()):
            own, some = limits[rows], np.ascontiguousarray(points[rows])
            found = {
                name: np.empty((len(own), *array.shape[1:]), np.float64 if name == "distance" else array.dtype)
                for name, array in arrays.items()
            }
            yield some, float(own.max(initial=0)), found
            limit_each(some, found, own)
            for name, array in arrays.items():
                array[rows] = found[name]

    def contains(self, points: ArrayLike, *, frame: FrameLike | None = None) -> npt.NDArray[np.bool_]:
        """Whether points (..., 3) are inside: an array (...), exact. One on the surface is not, nor one that is not
        finite. points, frame: as of query(). Raises clsdf.Error (invalid_mesh) if the mesh has no inside."""
        if self.sign == "none":
            raise Error("contains: the mesh is open, or its sign is 'none', so it has no inside; clsdf.Transform(mesh, "
                        "sign='nonzero') names the open edges", "invalid_mesh")
        points, shape = rows_of(points)
        if frame is not None:
            points = into_frame(points, *frame_of(frame))
        distance = np.empty(_cuda.shape_of(points)[0])
        self._body.query(points, 0.0, {"distance": distance}, None, None, False)  # which has the sign at any distance
        return np.asarray(np.signbit(distance) & ~np.isnan(distance)).reshape(shape)

    def classify(self, boxes: npt.ArrayLike, half_width: float) -> npt.NDArray[np.uint8]:
        """The place of each box, as numbers of clsdf.BoxPlace.

        boxes: an array (n, 2, 3) of lower and upper corners, in the mesh's units. A box that is not WITHIN lies on one
        side and is farther from the surface than half_width at each of its points; that is exact. One a little farther
        away may be WITHIN, too.
        """
        return self._body.classify(_meshes.boxes_of(boxes), limit_of(half_width, "half_width"))

    def winding(self, points: ArrayLike, *, out: ArrayLike | None = None, wait_for: Any = None) -> Any:
        """The generalised winding number at points anywhere: 1 or -1 inside a closed mesh, 0 outside, and values between
        near the holes of an open one, which the sign rule 'solid-angle' takes to be inside from 0.5 or -0.5 on.

        points: an array (n, 3) as of query(); or one point (3,), whose result is a number. out: an array (n,) of float32
        or float64 to write to. A point that is not finite gets NaN.
        """
        points = in_floats(points, remedy="")
        shape = _cuda.shape_of(points)
        is_one = len(shape) < 2
        if is_one:
            if shape != (3,):
                raise Error(f"points has the shape {shape}; expected (n, 3), or (3,) of one point")
            points = _cuda.reshaped(points, (1, 3))
        results: Any = np.empty(_cuda.shape_of(points)[0], np.float32) if out is None else out
        self._body.winding(points, results, wait_for)
        return results[0] if is_one and out is None else results

    # Links and crossings.

    def links(
        self,
        grid: Grid,
        directions: DirectionsLike = "D3Q19",
        *,
        hits: str = "walls",
        with_between: bool = False,
        dtype: npt.DTypeLike = np.float64,
        progress: Progress = None,
    ) -> Links:
        """The links of a grid that meet the surface: one if and only if its ends are on different sides, exact.

        directions: a stencil ("D3Q19" in the order of waLBerla, ("D3Q19", "OpenLB")), or whole numbers (n, 3), at most 32
        with components up to 16. hits: "walls", where inside and outside meet, or "faces", all faces as given, also of
        a mesh without a sign. with_between: also links with both ends outside and a body between them. dtype: of q.
        Raises clsdf.Error (invalid_argument) for directions or a grid out of range, and for walls without a sign.
        """
        grid, own = grid_of(grid), directions_of(directions)
        of_faces, in_floats = is_of_faces(hits), is_in_floats(dtype)
        with shown(progress) as show:
            return Links(grid, own, _core.links(self._body, grid, own, of_faces, with_between, in_floats, show))

    def link_slabs(
        self,
        grid: Grid,
        directions: DirectionsLike = "D3Q19",
        *,
        hits: str = "walls",
        with_between: bool = False,
        dtype: npt.DTypeLike = np.float64,
    ) -> Iterator[Links]:
        """The links of a grid of any size as an iterator of those of its slabs, whole slices in the order of z, which are
        those of slabs(). Options: as of links(). Each slab is computed when it is asked for; the rows, one slab after
        another, are those of the whole."""
        grid, own = grid_of(grid), directions_of(directions)
        of_faces, in_floats = is_of_faces(hits), is_in_floats(dtype)
        return (
            Links(part, own, _core.links(self._body, part, own, of_faces, with_between, in_floats, None))
            for part in _core.slabs_of(grid)
        )

    def plan_links(
        self,
        grid: Grid,
        directions: DirectionsLike = "D3Q19",
        *,
        room: int,
        hits: str = "walls",
        with_between: bool = False,
        progress: Progress = None,
    ) -> LinkPlan:
        """Prepares the links of a grid for runs that write at most `room` rows into memory of the device, without
        blocking. Options: as of links(). The links are found now and at each update, on a GPU by kernels."""
        grid, own = grid_of(grid), directions_of(directions)
        with shown(progress) as show:
            rows = whole("room", room, "links", least=0)
            plan = _core.plan_of_links(self._body, grid, own, rows, is_of_faces(hits), with_between, show)
            return self._reading(LinkPlan(plan))

    def count_links(
        self, grid: Grid, directions: DirectionsLike = "D3Q19", *, hits: str = "walls", with_between: bool = False
    ) -> int:
        """How many links links() would give."""
        return _core.count_links(self._body, grid_of(grid), directions_of(directions), is_of_faces(hits), with_between, None)

    def crossings(self, grid: Grid, *, counts: bool = False, progress: Progress = None) -> Crossings:
        """Where the edges of a grid between neighbouring samples meet walls, along x, y and z. counts: the number of
        walls on each edge, too."""
        grid = grid_of(grid)
        with shown(progress) as show:
            return Crossings(grid, _core.crossings(self._body, grid, counts, show))

    def rays(
        self,
        origins: ArrayLike,
        directions: ArrayLike,
        *,
        hits: str = "walls",
        limit: float | None = math.inf,
        most: int | None = None,
        counts: bool = False,
        dtype: npt.DTypeLike = "float64",
        progress: Progress = None,
        refuse_unusable_points: bool = False,
    ) -> Rays:
        """Where rays first meet the surface, exactly: none slips through an edge or a vertex (docs/rays.md).

        origins, directions: arrays (..., 3) that NumPy can broadcast, so that one origin serves many directions. A
            direction has any length; the point is origin + t * direction. Results have the shape (...).
        hits: "walls", where inside and outside meet; or "faces", every face as given, also of meshes without a sign.
        limit: hits beyond are left out, in lengths of the direction (None: no limit).
        most: as many hits of each ray, ascending: t and triangle have the shape (..., most). counts: all hits up to the
            limit, too. dtype: "float64" or "float32" for t.

        A ray whose origin is not finite, or whose direction is 0 or not finite, has t = NaN and no hits. One
        MeshWarning has their number; with refuse_unusable_points they raise clsdf.Error (invalid_argument). Raises
        clsdf.Error (unsupported) for walls of a mesh without a sign and for memory of a device. A restricted transform
        needs a limit up to which each ray lies in a region. Walls of the film of an open mesh, and walls and floor of
        the sign rule below, have t and clsdf.no_triangle.
        """
        from_points, along, shape = pairs_of(origins, directions, "origins", "directions")
        count = _cuda.shape_of(from_points)[0]
        components = 1 if most is None else whole("most", most, "hits")
        if components < 1:
            raise Error(f"most: {most!r} hits of each ray; ask for 1 or more")
        t = np.empty((count, components), real_of(dtype))
        triangle = np.empty((count, components), np.uint32)
        numbers = np.empty(count, np.uint32) if counts else None
        with shown(progress) as show:
            self._body.rays(
                from_points, along, hits, limit_of(limit, "limit", "lengths of the direction"), components, t, triangle, numbers, None, show,
                refuse_unusable_points,
            )
        of_hits = shape if most is None else (*shape, components)
        return Rays(
            _number_or_array(t.reshape(of_hits)),
            _number_or_array(triangle.reshape(of_hits)),
            None if numbers is None else _number_or_array(numbers.reshape(shape)),
        )

    def any_hit(
        self, origins: ArrayLike, directions: ArrayLike, *, hits: str = "walls", limit: float | None = math.inf,
        progress: Progress = None, refuse_unusable_points: bool = False,
    ) -> Any:
        """Whether rays meet the surface up to the limit: an array (...) of bool. Parameters: as of rays(). Cheaper, with
        hits="faces"."""
        from_points, along, shape = pairs_of(origins, directions, "origins", "directions")
        found = np.empty(_cuda.shape_of(from_points)[0], np.uint8)
        with shown(progress) as show:
            self._body.rays(
                from_points, along, hits, limit_of(limit, "limit", "lengths of the direction"), 1, None, None, None, found, show, refuse_unusable_points
            )
        return _number_or_array(found.view(np.bool_).reshape(shape))

    def visible(
        self, from_points: ArrayLike, to_points: ArrayLike, *, hits: str = "walls", progress: Progress = None,
        refuse_unusable_points: bool = False,
    ) -> Any:
        """Whether the segments between pairs of points meet nothing: an array (...) of bool. Points: as rays() takes
        them. hits: "walls", so that points on the surface see what lies outside; or "faces". A pair and its reverse
        agree. A pair with a point that is not finite does not see each other."""
        first, second, shape = pairs_of(from_points, to_points, "from_points", "to_points")
        found = np.empty(_cuda.shape_of(first)[0], np.uint8)
        with shown(progress) as show:
            self._body.visible(first, second, hits, found, show, refuse_unusable_points)
        return _number_or_array(found.view(np.bool_).reshape(shape))

    def restrict_to(self, regions: Region | Iterable[Region], margin: float = 0.0) -> Transform:
        """A transform for parts of the domain, which keeps only what they need, and not the mesh's arrays, but with
        surface='outer'. Every grid, point and box asked for later must lie in one region. The results have the bytes of
        the whole transform.

        margin: the longest way of a vertex, from where it is now, that set_positions() may give the part, in the mesh's
        units; 0 if they stay. set_positions() takes one position for each of part_vertices then:

            part.set_positions(positions[part.part_vertices])

        Gradients of a part that has moved raise clsdf.Error (unsupported) if motions by the margin can turn the mesh
        inside out."""
        plain = [_plain(region) for region in ([regions] if isinstance(regions, Region) else regions)]
        try:
            margin = float(margin)
        except (TypeError, ValueError):
            raise Error(f"margin: {margin!r} is no number; write how far a vertex may move, or 0") from None
        with self._moves:
            part, made_of = Transform.__new__(Transform), self._made_of
            is_outer = made_of.surface == "outer"  # which has no bytes
            part._keep(
                self._body.restrict_to(plain, margin), self.mesh_name,
                made_of if is_outer else made_of._replace(vertices=None, faces=None, sign=self.sign),
            )
            if is_outer:
                part._positions, part._motion = self._positions, self._motion
            part._regions = plain
        return part

    @property
    def part_vertices(self) -> npt.NDArray[np.uint32]:
        """Of a part with a margin: the numbers of its vertices in the mesh of the whole, ascending; of vertices with
        equal coordinates the lowest. Raises clsdf.Error (unsupported) for others."""
        return self._body.part_vertices()

    def part_bytes(self) -> bytes:
        """A restricted transform as bytes, for another process or for later: from_part() makes it again without the mesh
        and without the work of preparing it. 65 to 70 bytes for each triangle that it keeps, and up to 180 kB beside.
        Raises clsdf.Error (unsupported) for a whole transform, and for surface='outer'."""
        return self._body.part_bytes()

    @classmethod
    def from_part(cls, part: bytes, device: DeviceLike = None, kept_bytes: int | None = None) -> Transform:
        """The restricted transform that part_bytes() gave, on any device: the same results and refusals. It has no
        vertices and faces. The bytes are of the same version of clsdf and of this kind of machine; their hash tells
        damage, not forgery, so read bytes that you trust.

            mine = clsdf.Transform.from_part(comm.scatter(parts))      # mpi4py: the other ranks read no mesh

        Raises clsdf.Error: invalid_argument if the bytes are no part, not whole, damaged or of another version."""
        if not isinstance(part, bytes):
            raise Error(f"part: {repr(part)[:100]} is no bytes; pass what part_bytes() gave")
        return cls._without_mesh(_core.of_part(device_of(device), part, _meshes.kept_bytes_of(kept_bytes)), kept_bytes)

    # Shared memory.

    @property
    def prepared_bytes(self) -> int:
        """The bytes of memory that share() needs: about 640 for each face. Makes what is not made yet. Raises clsdf.Error
        (unsupported) for a transform that is restricted, has moved, or has surface='outer'."""
        return self._body.prepared_bytes()

    def share(self, memory: Any) -> None:
        """Writes all that the transform keeps of its mesh into memory that processes of a node share: a writable buffer
        of at least prepared_bytes, as `shm.buf` of multiprocessing.shared_memory, an mmap, an array, from a multiple of
        64 bytes on. from_shared() reads it there, so the mesh is in memory once, however many processes use it.

            shm = SharedMemory(create=True, size=body.prepared_bytes)
            body.share(shm.buf)

        Raises clsdf.Error: as prepared_bytes, and invalid_argument if the memory is too small or read-only."""
        bytes_of = _bytes_of(memory)
        if not bytes_of.flags.writeable:
            raise Error("memory: the buffer is read-only, and a transform is written into it; open it for writing")
        self._body.share(bytes_of)

    @classmethod
    def from_shared(cls, memory: Any, device: DeviceLike = None, kept_bytes: int | None = None) -> Transform:
        """The transform that share() wrote into this memory, which it reads in place: the same results. The memory must
        stay as it is while the transform or a plan of it is there; it keeps the buffer open. Checks all of it once. It
        has no vertices and faces, and is neither copied nor pickled. A GPU gets copies.

            shm = SharedMemory(name)                                   # in each process; keep shm
            body = clsdf.Transform.from_shared(shm.buf)

        Raises clsdf.Error: invalid_argument if the memory has no transform that is complete, undamaged and of this
        version of clsdf."""
        bytes_of = _bytes_of(memory)
        body = _core.of_shared(device_of(device), bytes_of, _meshes.kept_bytes_of(kept_bytes))
        made = cls._without_mesh(body, kept_bytes)
        made._memory = bytes_of
        return made

    # Plans.

    def _reading(self, plan: AnyPlan) -> AnyPlan:
        """The plan, which reads the memory that the transform reads."""
        plan._memory = self._memory
        return plan

    def plan(
        self,
        what: Grid | Iterable[Request],
        *,
        band: BandLike = "full",
        outputs: Outputs = "distance",
        exact_signs: bool = False,
        progress: Progress = None,
    ) -> Plan:
        """Prepares boxes that are computed again and again into the memory of the device, without blocking.

        what: a Grid, with band and outputs as of field(); each Plan.enqueue() gets the arrays then. Or Requests with
        pyopencl arrays of the device's context.
        """
        if not isinstance(what, Grid) and (band != "full" or wanted(outputs) != ("distance",) or exact_signs):
            raise Error("plan: a Request has its own band and outputs; band=, outputs= and exact_signs= are for a Grid")
        with self._turn(progress, "plan", wanted(outputs)) as show:
            if isinstance(what, Grid):
                grid, own_band = self._grid_and_band(what, band, exact_signs=exact_signs)
                return self._reading(Plan(_core.plan_of_grid(self._body, grid, own_band, wanted(outputs), show)))
            return self._reading(Plan(_core.plan_of_requests(self._body, self._requests(what), show)))

    def sparse_plan(
        self,
        grid: Grid,
        room: tuple[int, int],
        *,
        band: BandLike = "3v",
        outputs: Outputs = "distance",
        exact_signs: bool = False,
        progress: Progress = None,
    ) -> SparsePlan:
        """Prepares a sparse field that is computed again and again into memory of the device, and stays there.

        room: how many bricks and runs of bricks inside its runs have room for. grid, band and outputs: as of sparse().
        """
        with self._turn(progress, "sparse plan", wanted(outputs)) as show:
            own_grid, own_band = self._grid_and_band(grid, band, exact_signs=exact_signs)
            plan = _core.sparse_plan(self._body, own_grid, own_band, wanted(outputs), room_of(room), show)
            return self._reading(SparsePlan(plan))

    def plan_points(
        self, count: int, outputs: Outputs = "distance", *, within: float | None = math.inf, progress: Progress = None
    ) -> PointPlan:
        """Prepares the search for at most `count` points at a time that stay in the memory of the device, without
        blocking. outputs: as of field(). within: as of query(). The results have the bytes of query().

        The plan's own memory is about 200 bytes a point, of at most 2^20 points. Raises clsdf.Error (invalid_argument)
        for a mesh with a coordinate that is not 0 and, in units of about 1/256 of its longest side, smaller than 2^-300
        or greater than 2^300; unsupported for a restricted transform.
        """
        with self._turn(progress, "point plan", wanted(outputs)) as show:
            most = whole("count", count, "points", least=1)
            points = _core.plan_of_points(self._body, most, limit_of(within), wanted(outputs), show)
            return self._reading(PointPlan(points))

    def plan_bytes(self, requests: Iterable[Request], *, progress: Progress = None) -> int:
        """The device_bytes of a plan of these requests, which is made and given back: takes its time and its memory."""
        with shown(progress) as show:
            return self._body.plan_bytes(self._requests(requests), show)


def _bytes_of(memory: Any) -> npt.NDArray[np.uint8]:
    """The bytes of a buffer, which stays open as long as the array is there."""
    try:
        return np.frombuffer(memory, np.uint8)
    except (TypeError, ValueError, BufferError) as error:
        raise Error(
            f"memory: {repr(memory)[:100]} is no buffer in one piece ({error}); pass the buf of a SharedMemory, an mmap or "
            "an array of bytes"
        ) from None


def _part_again(part: bytes, device: Device, kept_bytes: int | None, regions: Any) -> Transform:
    made = Transform.from_part(part, device, kept_bytes)
    made._regions = regions
    return made


def _made_again(
    device: Device, mesh_name: str, made_of: MadeOf, positions: Any = None, motion: Any = None, regions: Any = None
) -> Transform:
    # The rule that was asked for decides again, as it did: a name in its place would count sheets that are left out.
    vertices, faces, sign, kept_bytes, floor, surface = made_of
    body = _core.make_body(device, vertices, faces, sign, kept_bytes, floor, surface == "outer", is_silent=True)
    made = Transform.__new__(Transform)
    made._keep(body, mesh_name, made_of)
    if positions is not None:
        made.set_positions(positions)
    if motion is not None:
        made.set_motion(*motion)
    return made if regions is None else made.restrict_to([Region(*region) for region in regions])
