"""Meshes of other packages as arrays of vertices (n, 3) and faces (m, 3). Nothing is copied if the package has such
arrays."""

from __future__ import annotations

import os
from typing import Any

import numpy as np

from . import _core, _cuda
from ._core import Device
from ._error import Error


def arrays_of(mesh: Any) -> tuple[Any, Any, str]:
    """Vertices, faces and a name of the mesh: of a path, (vertices, faces), or an object of trimesh, pyvista, meshio or
    open3d."""
    if isinstance(mesh, (str, os.PathLike)):
        path = os.fsdecode(mesh)
        vertices, faces = _core.read_mesh([path])
        return vertices, faces, os.path.basename(path)
    if isinstance(mesh, (tuple, list)):
        if len(mesh) != 2:
            raise Error(f"a mesh as a tuple is (vertices, faces); this one has {len(mesh)} items")
        return as_array(mesh[0], np.float64), as_array(mesh[1], np.int64), "mesh"
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


def as_array(values: Any, dtype: type) -> Any:
    """Lists and other objects without a shape become arrays; everything else stays what it is."""
    if hasattr(values, "shape") or hasattr(values, "__cuda_array_interface__"):
        return values
    try:
        return np.asarray(values, dtype)
    except (TypeError, ValueError):
        raise Error(f"{repr(values)[:100]} is no array of numbers: its rows differ in length, or it has other items") from None


def own_copy(values: Any, device: Device) -> Any:
    """A NumPy array of its own that nobody writes to, of an array of any package."""
    if hasattr(values, "base_data"):  # of pyopencl
        values = values.get()
    elif _cuda.is_in_cuda(values):
        values = _cuda.on_host(values, device, "the array")
    try:
        array = np.array(values)
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
    skip_bad_facets: bool = False,
) -> tuple[np.ndarray[Any, Any], np.ndarray[Any, Any]]:
    """Vertices (n, 3), float64, and faces (m, 3), uint32, of a file .off, .obj, .stl or .ply; of several files as one
    mesh: the vertices and faces of each follow those of the one before it. A coordinate x becomes x * scale + translate,
    in double: scale=0.001 makes metres of millimetres. weld: the tolerance of weld(), if it is not 0. skip_bad_facets: faces
    with a coordinate that is not finite, or that name a vertex that does not exist, are left out; without it they are
    errors. A MeshWarning says what was skipped or changed. Raises
    clsdf.Error: unreadable_input or invalid_mesh that names the line or the element; unsupported for an unknown ending;
    invalid_argument unless scale > 0."""
    vertices, faces = _core.read_mesh([os.fspath(name) for name in (path, *more)], scale, translate, skip_bad_facets)
    return (vertices, faces) if weld == 0 else _core.weld(vertices, faces, weld)


def mesh_hash(mesh: Any) -> int:
    """A number of 64 bits of all vertices and faces of a mesh, in their order: Mesh::hash() of C++, the same on every
    machine. Meshes that differ in one coordinate or one index never share it, other meshes with a chance of about
    2^-64. The processes of a parallel program compare it. mesh: as for Transform, in host memory. Raises clsdf.Error
    (invalid_mesh, unsupported)."""
    vertices, faces, _ = arrays_of(mesh)
    return _core.mesh_hash(vertices, faces)


def weld(mesh: Any, tolerance: float = 0.0) -> tuple[np.ndarray[Any, Any], np.ndarray[Any, Any]]:
    """The mesh in which vertices of equal coordinates are one vertex, as vertices (n, 3), float64, and faces (m, 3),
    uint32, which keep their order. So are vertices that differ by at most `tolerance` on every axis, in the mesh's
    units, or are connected by others that do; clusters longer than four tolerances are left apart. A MeshWarning says
    how many faces lose their area, as those of a wall that is thinner than the tolerance. mesh: as for mesh_hash()."""
    vertices, faces, _ = arrays_of(mesh)
    return _core.weld(vertices, faces, tolerance)


def find_defects(mesh: Any) -> _core.Defects:
    """Counts faces without area, duplicate faces and components; Transform.topology describes the edges. mesh: as for
    mesh_hash()."""
    vertices, faces, _ = arrays_of(mesh)
    return _core.find_defects(vertices, faces)
