"""Meshes of other packages as arrays of vertices (n, 3) and faces (m, 3). Nothing is copied if the package has such
arrays."""

from __future__ import annotations

import operator
import os
import sys
from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from . import _core, _cuda
from ._core import Device
from ._error import Error
from .typing import ArrayLike, MeshLike


class Groups(NamedTuple):
    """Groups of a mesh's faces: the name of the group of face f is names[numbers[f]]. Both are empty if there are none."""

    names: list[str]  #: all different; '' may be that of faces to which a file gives none
    numbers: npt.NDArray[np.int32]  #: (m,)

    def __repr__(self) -> str:
        return f"<clsdf.Groups: {self._few()} of {len(self.numbers)} faces>"

    def _few(self) -> str:
        return repr(self.names) if len(self.names) <= 8 else f"{len(self.names)}, {self.names[:4]!r} and others"

    def of(self, triangles: npt.ArrayLike) -> npt.NDArray[np.int32]:
        """The numbers of triangles, as the output `triangle` has them; -1 beyond the band."""
        triangles = np.asarray(triangles)
        if not self.numbers.size:
            return np.full(triangles.shape, -1, np.int32)
        is_one = (triangles >= 0) & (triangles < len(self.numbers))
        return np.where(is_one, self.numbers[np.where(is_one, triangles, 0)], np.int32(-1)).astype(np.int32)


class Mesh(tuple[Any, Any]):
    """Vertices and faces, to which it unpacks, with a name and groups of faces:

        vertices, faces = mesh = clsdf.read_mesh("case.stl")
        names, numbers = mesh.groups

    vertices: (n, 3) of float32 or float64. faces: (m, 3) of integers. groups: Groups, or a pair of names and numbers, one
    for each face. Raises clsdf.Error unless each face has a number, each number a name, and all names are different.
    """

    name: str
    groups: Groups

    def __new__(cls, vertices: ArrayLike, faces: ArrayLike, groups: Any = None, name: str = "mesh") -> Mesh:
        rows = as_array(faces, np.int64)
        mesh = super().__new__(cls, (as_array(vertices, np.float64), rows))
        mesh.name = name
        mesh.groups = Groups([], np.empty(0, np.int32)) if groups is None else _groups_of(groups, len(rows))
        return mesh

    @property
    def vertices(self) -> Any:
        """(n, 3)"""
        return self[0]

    @property
    def faces(self) -> Any:
        """(m, 3)"""
        return self[1]

    def __getnewargs__(self) -> tuple[Any, Any, Any, str]:
        return self[0], self[1], self.groups, self.name

    def __repr__(self) -> str:
        return f"<clsdf.Mesh: {self.name}, {len(self[0])} vertices, {len(self[1])} faces, groups {self.groups._few()}>"


def _groups_of(groups: Any, faces: int) -> Groups:
    try:
        names, given = groups
        numbers = np.asarray(given)
        if numbers.size and numbers.dtype.kind not in "iu":
            raise TypeError
    except (TypeError, ValueError):
        raise Error(f"groups: {repr(groups)[:100]} is no pair of names and whole numbers") from None
    names = [str(name) for name in names]
    if not names and not numbers.size:
        return Groups([], np.empty(0, np.int32))
    if numbers.shape != (faces,):
        raise Error(f"groups: the numbers have the shape {numbers.shape}; give one for each of {faces} faces")
    if numbers.size and not (0 <= numbers.min() and numbers.max() < len(names)):
        raise Error(f"groups: numbers are {numbers.min()} to {numbers.max()}, and there are {len(names)} names, from 0")
    if len(set(names)) < len(names):
        raise Error(f"groups: two of the names {names} are the same")
    return Groups(names, numbers.astype(np.int32))


def arrays_of(mesh: Any) -> tuple[Any, Any, str]:
    """Vertices, faces and a name of the mesh: of a path, (vertices, faces), or an object of trimesh, pyvista, meshio or
    open3d."""
    if isinstance(mesh, (str, os.PathLike)):
        path = os.fsdecode(mesh)
        vertices, faces, _ = _core.read_mesh([path])
        return vertices, faces, os.path.basename(path)
    if isinstance(mesh, Mesh):
        return mesh.vertices, mesh.faces, mesh.name
    if isinstance(mesh, OuterSurface) or isinstance(getattr(mesh, "surface", None), OuterSurface):
        place = "surface.mesh" if isinstance(mesh, OuterSurface) else "found.surface.mesh"
        raise Error(f"a {_name_of(mesh)} is no mesh; pass the mesh in it, {place}")
    if isinstance(mesh, (tuple, list)):
        if len(mesh) != 2:
            raise Error(f"a mesh as a tuple is (vertices, faces); this one has {len(mesh)} items")
        return as_array(mesh[0], np.float64), as_array(mesh[1], np.int64), "mesh"
    if hasattr(mesh, "add_instance"):
        raise Error("a clsdf.Scene is no mesh; scene.outer().surface.mesh is that of the union of its bodies")
    if hasattr(mesh, "_made_of"):
        _refuse_options(mesh)
    if hasattr(mesh, "geometry") and hasattr(mesh, "graph"):
        raise Error(f"a {_name_of(mesh)} is a scene of meshes: pass scene.to_mesh(), which makes one mesh of all, or a "
                    "Transform for each of scene.geometry.values()")
    if hasattr(mesh, "extract_surface") and not hasattr(mesh, "is_all_triangles"):
        raise Error(f"a {_name_of(mesh)} is no surface: pass mesh.extract_surface().triangulate()")
    for arrays in (_of_trimesh, _of_pyvista, _of_meshio, _of_open3d):
        found = arrays(mesh)
        if found is not None:
            return (*found, "mesh")
    raise Error(
        f"a {_name_of(mesh)} is no mesh that is known: pass a path, (vertices, faces), "
        "or a mesh of trimesh, pyvista, meshio or open3d"
    )


def number_of(name: str, value: Any, unit: str) -> float:
    try:
        if isinstance(value, (str, bool)):
            raise TypeError
        return float(value)
    except (TypeError, ValueError):
        raise Error(f"{name}: {repr(value)[:100]} is not a number, {unit}") from None


def _three(name: str, values: Any) -> tuple[float, float, float]:
    try:
        x, y, z = np.asarray(values, np.float64).tolist()
    except (TypeError, ValueError):
        raise Error(f"{name}: {repr(values)[:100]} is not three numbers, x, y and z") from None
    return x, y, z


def _refuse_options(body: Any) -> None:
    """A transform is taken as its mesh, without what it was told about the sign."""
    made_of = body._made_of
    if made_of.vertices is None:  # a part, or of shared memory: its vertices say so
        return
    told = [f"{name}={value!r}" for name, usual in (("sign", "auto"), ("floor", None), ("surface", "given"))
            if (value := getattr(made_of, name)) != usual]
    if told:
        raise Error(f"a clsdf.Transform is taken as its mesh alone, and this one has {', '.join(told)}; pass "
                    "(body.vertices, body.faces), and the options again where they are taken")


def as_array(values: Any, dtype: type) -> Any:
    """Lists and other objects without a shape become arrays; everything else stays what it is."""
    if hasattr(values, "shape") or hasattr(values, "__cuda_array_interface__"):
        return values
    try:
        return np.asarray(values, dtype)
    except (TypeError, ValueError):
        raise Error(f"{repr(values)[:100]} is no array of numbers: its rows differ in length, or it has other items") from None


def refuse_graph(name: str, array: Any, remedy: str = "") -> None:
    """Raises clsdf.Error for a tensor of torch that requires a gradient, which the result would not have; not within
    torch.no_grad()."""
    if isinstance(array, np.ndarray) or not getattr(array, "requires_grad", False):
        return
    torch = sys.modules.get("torch")
    if torch is not None and torch.is_grad_enabled():
        raise Error(f"{name} requires a gradient, which this call does not give: {remedy}pass tensor.detach()")


def boxes_of(boxes: Any) -> npt.NDArray[np.float64]:
    """Lower and upper corners of boxes, (n, 2, 3)."""
    try:
        corners = np.ascontiguousarray(boxes, np.float64)
    except (TypeError, ValueError):
        raise Error(f"boxes: {repr(boxes)[:100]} is no array of numbers (n, 2, 3)") from None
    if corners.ndim != 3 or corners.shape[1:] != (2, 3):
        raise Error(f"boxes has the shape {corners.shape}; expected (n, 2, 3): lower and upper corner of each box")
    return corners


def is_outer(surface: Any) -> bool:
    if surface not in ("given", "outer"):
        raise Error(f"surface: {surface!r} is unknown; write 'given' or 'outer'")
    return bool(surface == "outer")


def kept_bytes_of(kept_bytes: Any) -> int | None:
    if kept_bytes is None:
        return None
    try:
        number = -1 if isinstance(kept_bytes, bool) else operator.index(kept_bytes)
    except TypeError:
        number = -1
    if not 0 <= number < 2**64:
        raise Error("kept_bytes is not a number of bytes, 0 or more; write 1 << 30 for a GiB, or None")
    return number


def own_copy(values: Any, device: Device) -> Any:
    """A NumPy array of its own that nobody writes to, of an array of any package."""
    if hasattr(values, "base_data"):  # of pyopencl
        values = values.get()
    elif _cuda.is_in_cuda(values):
        values = _cuda.on_host(values, device, "the array")
    try:
        array = np.array(np.asarray(values))  # np.array() of other packages' arrays warns if they cannot copy
        if array.dtype == object:
            raise TypeError
    except (TypeError, ValueError):
        array = np.array(np.from_dlpack(values))
    array.flags.writeable = False
    return array


def _name_of(mesh: Any) -> str:
    return f"{type(mesh).__module__.split('.')[0]}.{type(mesh).__qualname__}"


def _of_trimesh(mesh: Any) -> tuple[Any, Any] | None:
    if hasattr(mesh, "vertices") and hasattr(mesh, "faces"):
        return mesh.vertices, mesh.faces
    return None


def _of_pyvista(mesh: Any) -> tuple[Any, Any] | None:
    if not (hasattr(mesh, "points") and hasattr(mesh, "is_all_triangles")):
        return None
    triangles = mesh if mesh.is_all_triangles else mesh.triangulate()
    return np.asarray(triangles.points), np.asarray(triangles.faces).reshape(-1, 4)[:, 1:]


def _of_meshio(mesh: Any) -> tuple[Any, Any] | None:
    if not (hasattr(mesh, "points") and hasattr(mesh, "cells_dict")):
        return None
    kinds = mesh.cells_dict
    others = [kind for kind in kinds if kind not in ("triangle", "vertex", "line")]
    if "triangle" not in kinds or others:
        raise Error(f"the meshio mesh has cells of the kinds {', '.join(kinds)}; clsdf takes triangles alone")
    return mesh.points, kinds["triangle"]


def _of_open3d(mesh: Any) -> tuple[Any, Any] | None:
    if hasattr(mesh, "vertices") and hasattr(mesh, "triangles"):
        return np.asarray(mesh.vertices), np.asarray(mesh.triangles)
    if hasattr(mesh, "vertex") and hasattr(mesh, "triangle"):  # open3d.t.geometry
        return mesh.vertex.positions.numpy(), mesh.triangle.indices.numpy()
    return None


def read_mesh(
    path: str | os.PathLike[str],
    *more: str | os.PathLike[str],
    scale: float = 1.0,
    translate: Any = (0.0, 0.0, 0.0),
    weld: float = 0.0,
    up: str = "z",
    rotate: Any = (0.0, 0.0, 0.0),
    group_by: str = "",
    skip_bad_facets: bool = False,
) -> Mesh:
    """Vertices (n, 3), float64, and faces (m, 3), uint32, of a file .off, .obj, .stl or .ply; of several files as one
    mesh: the vertices and faces of each follow those of the one before it.

    A position x becomes R (x * scale) + translate, in double: scale=0.001 makes metres of millimetres. The rotation R
    makes z of the axis that points up in the file ('x', 'y', 'z', '-x', '-y' or '-z'), and then rotates by the degrees
    of `rotate` about x, y and z, one after the other; right angles round nothing. weld: the tolerance of weld(), if it is
    not 0. skip_bad_facets: faces with a coordinate that is not finite, or that name a vertex that does not exist, are left
    out; without it they are errors.

    The mesh's `groups` are the solids of an ASCII STL file, the groups and objects of an OBJ file ('object/group'), the
    values of the property `group_by` of a PLY file's faces, or several files, by their names without folder and ending
    ('file/group' if a file has several groups).

    A MeshWarning says what was skipped or changed. Raises clsdf.Error: unreadable_input or invalid_mesh that names the
    line or the element; unsupported for an unknown ending; invalid_argument unless scale > 0, or for a property that
    there is not."""
    paths = [os.fsdecode(name) for name in (path, *more)]
    vertices, faces, groups = _core.read_mesh(
        paths, number_of("scale", scale, "as 0.001, which makes metres of millimetres"), _three("translate", translate), up,
        _three("rotate", rotate), group_by, skip_bad_facets,
    )  # fmt: skip
    tolerance = number_of("weld", weld, "in the units of the mesh")
    if tolerance != 0:
        vertices, faces = _core.weld(vertices, faces, tolerance)
    mesh = Mesh(vertices, faces, name=" + ".join(os.path.basename(os.fsdecode(name)) for name in paths))
    mesh.groups = Groups(*groups)
    return mesh


def mesh_hash(mesh: MeshLike) -> int:
    """A number of 64 bits of all vertices and faces of a mesh, in their order: Mesh::hash() of C++, the same on every
    machine. Meshes that differ in one coordinate or one index never share it, other meshes with a chance of about
    2^-64. The processes of a parallel program compare it. mesh: as for Transform, in host memory. Raises clsdf.Error
    (invalid_mesh, unsupported)."""
    vertices, faces, _ = arrays_of(mesh)
    return _core.mesh_hash(vertices, faces)


def weld(mesh: MeshLike, tolerance: float = 0.0) -> Mesh:
    """The mesh in which vertices of equal coordinates are one vertex, as vertices (n, 3), float64, and faces (m, 3),
    uint32, which keep their order. So are vertices that differ by at most `tolerance` on every axis, in the mesh's
    units, or are connected by others that do; clusters longer than four tolerances are left apart. A MeshWarning says
    how many faces lose their area, as those of a wall that is thinner than the tolerance. The groups of a Mesh stay.
    mesh: as for mesh_hash()."""
    vertices, faces, name = arrays_of(mesh)
    welded = Mesh(*_core.weld(vertices, faces, number_of("tolerance", tolerance, "in the units of the mesh")), name=name)
    if isinstance(mesh, Mesh):
        welded.groups = mesh.groups
    return welded


def close_down(mesh: MeshLike, floor: float) -> Mesh:
    """A terrain closed by vertical walls from its rim down to z = floor, and by a floor there: the mesh whose inside the
    sign rule 'below' takes. The vertices and faces of the terrain come first, with their numbers. Raises clsdf.Error
    (invalid_mesh) if a face looks down or if the rim overlaps itself, seen from above; (invalid_argument) if the floor
    is not below all vertices. mesh: as for mesh_hash()."""
    vertices, faces, name = arrays_of(mesh)
    return Mesh(*_core.close_down(vertices, faces, number_of("floor", floor, "the z of the floor")), name=name)


class OuterSurface(NamedTuple):
    """The outer surface of a mesh: the boundary of what its sign rule says is inside."""

    mesh: Mesh  #: closed; faces look outwards; the groups are those of the faces as given
    faces: npt.NDArray[np.uint32]  #: (m,): of each face of `mesh` the number of the face as given that it is a part of
    whole_faces: int  #: faces as given that are on the outer surface wholly,
    partial_faces: int  #: in parts,
    hidden_faces: int  #: and not at all
    volume: float  #: inside, in cubed units of the mesh
    area: float  #: of the outer surface, in squared units

    def __repr__(self) -> str:
        return (f"<clsdf.OuterSurface: {len(self.mesh.faces)} faces; of those given {self.whole_faces} whole, "
                f"{self.partial_faces} in parts, {self.hidden_faces} hidden; volume {self.volume:.6g}, area {self.area:.6g}>")


def outer(mesh: MeshLike, sign: str = "auto") -> OuterSurface:
    """The outer surface of a mesh whose parts may overlap, touch, repeat or contain each other: those parts of its faces
    that have the outside on one side and the inside on the other. Faces are cut where they meet, which is decided exactly;
    new vertices are rounded once, by at most half an ulp of each coordinate. A Transform of it has the distance to the
    union of the parts, and triangle t is a part of the face faces[t] as given.

    sign: 'auto', 'nonzero' or 'parity'. Raises clsdf.Error: unsupported if the mesh has another rule; invalid_mesh if it
    does not meet the rule, or if nothing is inside. Uses all cores, without the GIL. mesh: as for mesh_hash()."""
    vertices, faces, name = arrays_of(mesh)
    surface = surface_of(_core.outer(vertices, faces, sign), name)
    if isinstance(mesh, Mesh) and mesh.groups.numbers.size:
        surface.mesh.groups = Groups(mesh.groups.names, mesh.groups.numbers[surface.faces])
    return surface


def surface_of(found: tuple[Any, ...], name: str) -> OuterSurface:
    vertices, faces, *rest = found
    return OuterSurface(Mesh(vertices, faces, name=name), *rest)


def _normals_of(vertices: npt.NDArray[Any], faces: npt.NDArray[Any]) -> Iterator[tuple[npt.NDArray[Any], npt.NDArray[Any]]]:
    """First corners and normals, as long as twice the areas, of so many faces at a time that they need little memory."""
    middle = vertices[faces[:1]].mean(axis=(0, 1), dtype=np.float64) if len(faces) else np.zeros(3)
    for begin in range(0, len(faces), 1 << 18):
        a, b, c = (vertices[faces[begin : begin + (1 << 18), n]] - middle for n in range(3))
        yield a, np.cross(b - a, c - a)


def volume_of(vertices: npt.NDArray[Any], faces: npt.NDArray[Any]) -> float:
    """Positive of a closed mesh whose faces look outwards."""
    return sum(float(np.einsum("ni,ni", corner, normal)) for corner, normal in _normals_of(vertices, faces)) / 6


def area_of(vertices: npt.NDArray[Any], faces: npt.NDArray[Any]) -> float:
    return sum(float(np.linalg.norm(normal, axis=1).sum()) for _, normal in _normals_of(vertices, faces)) / 2


def find_defects(mesh: MeshLike) -> _core.Defects:
    """Counts faces without area, duplicate faces and components; Transform.topology describes the edges. mesh: as for
    mesh_hash()."""
    vertices, faces, _ = arrays_of(mesh)
    return _core.find_defects(vertices, faces)
