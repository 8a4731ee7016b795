"""Arrays in memory of CUDA: of torch, CuPy, JAX, and all that have __cuda_array_interface__ or DLPack."""

from __future__ import annotations

import math
import sys
from typing import Any

import numpy as np
import numpy.typing as npt

from . import _core
from ._core import Device
from ._error import Error

#: CU_STREAM_LEGACY, which torch and CuPy call 0.
_default_stream = 1

is_in_cuda = _core.is_in_cuda


def _is_of_torch(array: Any) -> bool:
    """Whether an array is a tensor of torch, also of a subclass in another package."""
    return isinstance(array, getattr(sys.modules.get("torch"), "Tensor", ()))


def stream_of(array: Any) -> int:
    """The stream on which the package of an array works now."""
    if _is_of_torch(array):
        return int(sys.modules["torch"].cuda.current_stream(array.device).cuda_stream or _default_stream)
    interface = getattr(array, "__cuda_array_interface__", None)
    return int((interface or {}).get("stream") or _default_stream)


def described(array: Any) -> tuple[dict[str, Any] | None, Any, int]:
    """The __cuda_array_interface__ of an array, or else its DLPack capsule; and the stream on which its package works."""
    package = type(array).__module__.partition(".")[0]
    if package in ("jax", "jaxlib"):
        array.block_until_ready()  # JAX does not tell its streams
    stream = stream_of(array)
    if _is_of_torch(array):
        array = array.detach()
    interface = getattr(array, "__cuda_array_interface__", None)
    if interface is None:
        return None, array.__dlpack__(stream=stream), stream
    if interface.get("mask") is not None:
        raise Error(f"an array of {package} has a mask, which is not taken; pass an array without one")
    return interface, None, stream


def shape_of(array: Any) -> tuple[int, ...]:
    """The shape of any array."""
    if hasattr(array, "shape"):
        return tuple(array.shape)
    if hasattr(array, "__cuda_array_interface__"):
        return tuple(array.__cuda_array_interface__["shape"])
    return np.shape(array)


class Reshaped:
    """A packed array in memory of CUDA with another shape: for packages' arrays that have no reshape()."""

    def __init__(self, array: Any, shape: tuple[int, ...]) -> None:
        interface = dict(array.__cuda_array_interface__)
        if interface.get("strides") is not None:
            raise Error(f"an array of the shape {interface['shape']} in memory of CUDA is not packed, so its rows cannot "
                        "be told; pass one of the shape (n, 3)")
        self._array, self.shape = array, shape
        self.__cuda_array_interface__ = {**interface, "shape": shape}

    def __len__(self) -> int:
        return self.shape[0]


def reshaped(array: Any, shape: tuple[int, ...]) -> Any:
    """The same memory with another shape."""
    return array.reshape(shape) if hasattr(array, "reshape") else Reshaped(array, shape)


def on_host(array: Any, device: Device, what: str) -> npt.NDArray[Any]:
    """A copy in the host's memory."""
    found: Any = _core.copied_to_host(device, array, what)
    content, begin, shape, strides, dtype = found
    if math.prod(shape) == 0:
        return np.empty(shape, dtype)
    return np.ndarray(tuple(shape), dtype, content, begin, tuple(strides)).copy()
