"""The device that transforms use if none is named."""

from __future__ import annotations

import threading
from typing import Any

from ._core import Device
from ._error import Error

_lock = threading.Lock()
_default: Device | None = None


def default_device() -> Device:
    """Device.automatic(), opened once."""
    global _default
    with _lock:
        if _default is None:
            _default = Device.automatic()
        return _default


def device_of(choice: Any) -> Device:
    """None, a Device, an index or a part of a name, or a pyopencl queue."""
    if choice is None:
        return default_device()
    if isinstance(choice, Device):
        return choice
    if isinstance(choice, (str, int)):
        return Device.select(str(choice))
    if not hasattr(choice, "int_ptr"):
        raise Error(f"device: {choice!r} is no clsdf.Device, index, part of a device's name, or pyopencl.CommandQueue")
    return Device.from_queue(choice)
