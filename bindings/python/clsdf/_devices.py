"""The device that transforms use if none is named."""

from __future__ import annotations

import copyreg
import threading
from typing import Any

from ._core import Device, devices
from ._error import Error

_lock = threading.Lock()
_default: Device | None = None
_again: dict[tuple[str, int | None, int | None], Device] = {}


def default_device() -> Device:
    """Device.automatic(), opened once."""
    global _default
    with _lock:
        if _default is None:
            _default = Device.automatic()
        return _default


def _state_of(device: Device) -> tuple[str, int | None, int | None]:
    """A device's name, and its limits: those of limited(), or the share of of_rank()."""
    own = device.info()
    whole = next((info for info in devices() if info.name == own.name and info.platform == own.platform), own)
    return (
        own.name,
        own.compute_units if own.compute_units < whole.compute_units else None,
        own.memory if own.memory < whole.memory else None,
    )


def device_again(name: str, compute_units: int | None = None, memory: int | None = None) -> Device:
    """The default device if it has the name, else the first usable one that has; with limits; opened once."""
    key = name, compute_units, memory
    with _lock:
        if key in _again:
            return _again[key]
    if compute_units is not None or memory is not None:
        whole = device_again(name)
        info = whole.info()
        # Another machine's device of this name may have less.
        units = None if compute_units is None or compute_units >= info.compute_units else compute_units
        room = None if memory is None or memory >= info.memory else memory
        opened = whole if units is None and room is None else whole.limited(units, room)
        with _lock:
            return _again.setdefault(key, opened)
    found = next((info for info in devices() if info.name == name and info.usable), None)
    if found is None:
        raise Error(
            f"it was made on the device '{name}', which this machine does not have; send the mesh, "
            "(vertices, faces), and make the transform there",
            "no_device",
        )
    own = default_device()
    opened = own if own.name == name else Device.select(str(found.index))
    with _lock:
        return _again.setdefault(key, opened)


def _reduced(device: Device) -> tuple[Any, ...]:
    return device_again, _state_of(device)


copyreg.pickle(Device, _reduced)
setattr(Device, "__copy__", lambda device: device)
setattr(Device, "__deepcopy__", lambda device, memo: device)


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
