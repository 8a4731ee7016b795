"""Exact signed distance fields of triangle meshes, computed with OpenCL.

The inside is negative. Arrays of samples have the shape (nz, ny, nx), z first; positions, sizes and vectors are in the
order x, y, z. Lengths are in the mesh's units.

    import clsdf
    body = clsdf.Transform("bunny.off")
    f = body.field(resolution=256, band="10%", outputs="distance gradient")
    f.distance[k, j, i]
    body.query(points).distance
"""

from __future__ import annotations

import importlib as _importlib
import typing as _typing

from . import _core
from ._core import Band, Defects, Device, DeviceInfo, Grid, Topology, devices, make_shape, shape_names
from . import _signatures
from ._error import Error, InvalidArgument, InvalidMesh, MeshWarning, OutOfMemory, OutputFailure, UnreadableInput, Unsupported
from ._values import Blocks, Points
from ._field import Field, FieldWriter, read_field, slice_picture, write_field, write_overlapping_amr
from ._fractions import Fractions, fractions
from ._links import Crossings, EdgeCrossings, Links, stencil
from ._pictures import Picture
from ._plan import LinkPlan, Plan, PointPlan, PointStatus, Request, SparsePlan
from ._scene import Scene, ScenePoints, SceneSurface
from ._shared import SharedArray
from ._sparse import SparseField, read_sparse_field
from ._transform import BoxPlace, Rays, Region, Transform

#: Another name of Transform, for those to whom a transform is a pose.
Body = Transform

_core._set_error_class(Error)  # type: ignore[attr-defined]

from ._meshes import Groups, Mesh, OuterSurface, close_down, find_defects, mesh_hash, outer, read_mesh, weld  # noqa: E402
from . import trimesh, typing  # noqa: E402

if _typing.TYPE_CHECKING:
    from . import jax, torch

#: The triangle and the site of a sample beyond the band.
no_triangle = 0xFFFFFFFF
no_site = 255
#: The body of a point beyond the limit, in a scene.
no_body = 0xFFFFFFFF

__version__ = _core.version()
__all__ = [
    "Band",
    "Blocks",
    "Body",
    "BoxPlace",
    "Crossings",
    "Defects",
    "Device",
    "DeviceInfo",
    "EdgeCrossings",
    "Error",
    "Field",
    "FieldWriter",
    "Fractions",
    "Grid",
    "Groups",
    "InvalidArgument",
    "InvalidMesh",
    "LinkPlan",
    "Links",
    "Mesh",
    "MeshWarning",
    "OutOfMemory",
    "OuterSurface",
    "OutputFailure",
    "Picture",
    "Plan",
    "PointPlan",
    "PointStatus",
    "Points",
    "Rays",
    "Region",
    "Request",
    "Scene",
    "ScenePoints",
    "SceneSurface",
    "SharedArray",
    "SparseField",
    "SparsePlan",
    "Topology",
    "Transform",
    "UnreadableInput",
    "Unsupported",
    "close_down",
    "devices",
    "find_defects",
    "fractions",
    "make_shape",
    "mesh_hash",
    "no_body",
    "no_site",
    "no_triangle",
    "outer",
    "read_field",
    "read_mesh",
    "read_sparse_field",
    "shape_names",
    "slice_picture",
    "stencil",
    "trimesh",
    "typing",
    "weld",
    "write_field",
    "write_overlapping_amr",
]



class _Signature:
    """The signature of a class of the extension, for notebooks. They alone import inspect, which takes long."""

    def __init__(self, like: _typing.Callable[..., object]) -> None:
        self._like = like

    def __get__(self, instance: object, owner: type) -> object:
        import inspect

        return inspect.signature(self._like)


for _kind in (Device, Grid):
    _signatures.give(_kind)
if not _typing.TYPE_CHECKING:
    devices, make_shape, shape_names = map(_signatures.as_python, (devices, make_shape, shape_names))
setattr(Grid, "__signature__", _Signature(lambda origin, spacing, size, first=(0, 0, 0): 0))
setattr(Band, "__signature__", _Signature(lambda inside, outside=None, *, exact_signs=False: 0))
# Classes are those of the package, and its files are not beside them.
for _name in __all__:
    if isinstance(globals()[_name], type):
        globals()[_name].__module__ = "clsdf"
globals().pop("annotations")
del _name, _kind


def __getattr__(name: str) -> _typing.Any:
    """clsdf.torch and clsdf.jax, which import PyTorch and JAX, when they are first used."""
    if name in ("jax", "torch"):
        return _importlib.import_module(f"clsdf.{name}")
    raise AttributeError(f"module 'clsdf' has no attribute '{name}'")
