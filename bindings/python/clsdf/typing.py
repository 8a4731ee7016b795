"""Types of what functions take, for annotations of your own: clsdf.typing.MeshLike and others. Nothing here is checked
when a program runs."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from typing import Any, Protocol, Union

import numpy as np

from ._core import Device
from ._lengths import BandLike, LengthLike
from ._values import Outputs, Values

__all__ = ["ArrayLike", "BandLike", "DeviceLike", "FrameLike", "LengthLike", "MeshLike", "OutLike", "Outputs", "RotationLike"]


class _HasArray(Protocol):
    """numpy.ndarray, and arrays of most packages."""

    def __array__(self) -> np.ndarray[Any, Any]: ...


class _HasDLPack(Protocol):
    def __dlpack__(self, *arguments: Any, **options: Any) -> Any: ...


class _InCuda(Protocol):
    """Arrays in memory of CUDA."""

    @property
    def __cuda_array_interface__(self) -> Any: ...


class _InOpenCL(Protocol):
    """pyopencl.array.Array"""

    @property
    def base_data(self) -> Any: ...


class _HasHandle(Protocol):
    """pyopencl.Buffer, pyopencl.CommandQueue"""

    @property
    def int_ptr(self) -> int: ...


_Array = Union[_HasArray, _HasDLPack, _InCuda, _InOpenCL, memoryview]

#: An array of NumPy or another package, in the host's memory or the device's; or lists of numbers. No text.
ArrayLike = Union[
    _Array,
    Sequence[Union[float, _Array]],
    Sequence[Sequence[Union[float, _Array]]],
    Sequence[Sequence[Sequence[Union[float, _Array]]]],
]


class _OfTrimesh(Protocol):
    @property
    def vertices(self) -> Any: ...
    @property
    def faces(self) -> Any: ...


class _OfOpen3d(Protocol):
    @property
    def vertices(self) -> Any: ...
    @property
    def triangles(self) -> Any: ...


class _OfOpen3dTensors(Protocol):
    @property
    def vertex(self) -> Any: ...
    @property
    def triangle(self) -> Any: ...


class _OfPyvista(Protocol):
    @property
    def points(self) -> Any: ...
    @property
    def is_all_triangles(self) -> Any: ...


class _OfMeshio(Protocol):
    @property
    def points(self) -> Any: ...
    @property
    def cells_dict(self) -> Any: ...


#: A mesh: a path, (vertices, faces), a clsdf.Mesh, or a mesh of trimesh, pyvista, meshio or open3d.
MeshLike = Union[
    str, "os.PathLike[str]", tuple[ArrayLike, ArrayLike], _OfTrimesh, _OfPyvista, _OfMeshio, _OfOpen3d, _OfOpen3dTensors
]

#: A device: a clsdf.Device, an index or a part of a name, a pyopencl.CommandQueue, or None for Device.automatic().
DeviceLike = Union[Device, int, str, _HasHandle, None]

#: Arrays to write to: a result, a dictionary by names of outputs, or the array of the distance.
OutLike = Union[Values, Mapping[str, Union[_Array, _HasHandle]], _Array, _HasHandle]


class _HasMatrix(Protocol):
    """scipy.spatial.transform.Rotation and RigidTransform"""

    def as_matrix(self) -> Any: ...


#: A rotation: a matrix (3, 3), or a Rotation of scipy; or both with a translation: a matrix (4, 4), or a RigidTransform.
RotationLike = Union[ArrayLike, _HasMatrix]

#: A motion: a RotationLike that has a translation or needs none, or a tuple of a rotation and a translation.
FrameLike = Union[RotationLike, tuple[RotationLike, ArrayLike]]
