"""The device that transforms use if none is named."""

from __future__ import annotations

import threading
from typing import Any

from ._core import Device, devices
from ._error import Error

_lock = threading.Lock()
_default: Device | None = None
_by_name: dict[str, Device] = {}


def default_device() -> Device:
    """Device.automatic(), opened once."""
    global _default
    with _lock:
        if _default is None:
            _default = Device.automatic()
        return _default


def device_named(name: str) -> Device:
    """The default device if it has the name, else the first usable one that has; opened once."""
    with _lock:
        if name in _by_name:
            return _by_name[name]
    found = next((info for info in devices() if info.name == name and info.usable), None)
    if found is None:
        raise Error(
            f"the transform was made on the device '{name}', which this machine does not have; send the mesh, "
            "(vertices, faces), and make the transform there",
            "no_device",
        )
    own = default_device()
    opened = own if own.name == name else Device.select(str(found.index))
    with _lock:
        return _by_name.setdefault(name, opened)


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
