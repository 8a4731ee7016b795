"""Memory of the device that CUDA and clsdf share."""

from __future__ import annotations

import math
import operator
from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from . import _core, _cuda
from ._core import Device
from ._devices import device_of
from ._error import Error
from .typing import DeviceLike


class SharedArray:
    """An array in memory of an NVIDIA GPU that torch, CuPy and JAX see, and that clsdf reads and writes without a copy.

    shape: a number or a tuple. dtype: float32, float64, int32, int64, uint32, uint64 or uint8. device: as of Transform;
        the transforms that use it without a copy have the same clsdf.Device or queue. The content is undefined.

    It has __cuda_array_interface__ and DLPack: torch.as_tensor(shared, device="cuda"), cupy.asarray(shared) and
    jax.numpy.from_dlpack(shared) are the same memory, which lives as long as one of them. It is freed with the last one,
    which waits for the device. Works in the order of CUDA's default stream.

    Raises clsdf.Error: no_device if there is no driver of CUDA, or if CUDA does not list the device; unsupported if the
    device shares no memory; out_of_memory.
    """

    def __init__(self, shape: int | Sequence[int], dtype: npt.DTypeLike = np.float32, device: DeviceLike = None) -> None:
        try:
            sides: Any = shape if np.ndim(shape) else (shape,)
            self._shape = tuple(operator.index(side) for side in sides)
            self._dtype = np.dtype(dtype)
        except (TypeError, ValueError):
            raise Error(f"SharedArray: {shape!r} is no shape, or {dtype!r} is no type of numbers") from None
        if self._dtype.name not in ("float32", "float64", "int32", "int64", "uint32", "uint64", "uint8"):
            raise Error(f"SharedArray: dtype {dtype!r} is none of float32, float64, int32, int64, uint32, uint64, uint8")
        if min(self._shape, default=0) < 0:
            raise Error(f"SharedArray: the shape {self._shape} has a side below 0")
        self._memory = _core.SharedMemory(device_of(device), self.nbytes)

    def __repr__(self) -> str:
        return f"<clsdf.SharedArray: shape {self._shape}, {self._dtype.name}, on {self.device.name}>"

    def __len__(self) -> int:
        if not self._shape:
            raise TypeError("a SharedArray of the shape () has no length")
        return self._shape[0]

    @property
    def shape(self) -> tuple[int, ...]:
        return self._shape

    @property
    def dtype(self) -> np.dtype[Any]:
        return self._dtype

    @property
    def nbytes(self) -> int:
        """Bytes of its elements; the memory is a multiple of 2 MiB."""
        return math.prod(self._shape) * self._dtype.itemsize

    @property
    def device(self) -> Device:
        """The clsdf.Device."""
        return self._memory.device

    @property
    def buffer_int_ptr(self) -> int:
        """The cl_mem, for pyopencl.MemoryObject.from_int_ptr(). Commands may use it only between
        clEnqueueAcquireExternalMemObjectsKHR and clEnqueueReleaseExternalMemObjectsKHR."""
        return self._memory.buffer_int_ptr

    @property
    def __cuda_array_interface__(self) -> dict[str, Any]:
        return {
            "shape": self._shape,
            "typestr": self._dtype.str,
            "data": (self._memory.address, False),
            "strides": None,
            "version": 3,
            "stream": 1,
        }

    def __dlpack_device__(self) -> tuple[int, int]:
        return 2, self._memory.ordinal

    def __dlpack__(
        self,
        *,
        stream: int | None = None,
        max_version: tuple[int, int] | None = None,
        dl_device: tuple[int, int] | None = None,
        copy: bool | None = None,
    ) -> Any:
        if dl_device is not None and tuple(dl_device) != self.__dlpack_device__():
            raise BufferError(f"a clsdf.SharedArray is on the device {self.__dlpack_device__()} of DLPack, not {dl_device}")
        if copy:
            raise BufferError("a clsdf.SharedArray is shared, not copied; copy what you get")
        return self._memory.dlpack(self._shape, self._dtype.kind, self._dtype.itemsize, stream, max_version)

    def get(self) -> npt.NDArray[Any]:
        """A copy in the host's memory, in the order of CUDA's default stream."""
        return _cuda.on_host(self, self.device, "the array")

    def set(self, values: npt.ArrayLike) -> None:
        """Copies values of the host, of the same shape or of one that NumPy broadcasts to it. Blocks."""
        content = np.empty(self._shape, self._dtype)
        content[...] = values
        _core.copy_from_host(self.device, self, content.reshape(-1).view(np.uint8))
