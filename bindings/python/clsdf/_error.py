"""The exceptions and the warning of the package."""

from __future__ import annotations

from typing import Any


class Error(RuntimeError):
    """Every failure of clsdf. The message names the thing, the value and the remedy.

    code: the kind of the failure as text: 'invalid_mesh', 'unreadable_input', 'invalid_argument', 'no_device',
        'device_failure', 'out_of_memory', 'unsupported', 'cancelled', 'output_failure' or 'wrong_results'.
    opencl_code: the number that a failed call of OpenCL returned, else 0.

    An error of a code that Python has an exception for is of a class that is both: Error(message, 'out_of_memory')
    makes a clsdf.OutOfMemory, which is a MemoryError.
    """

    def __new__(cls, message: str = "", code: str = "invalid_argument", opencl_code: int = 0) -> Error:
        kind = _kinds.get(code, cls) if cls is Error else cls
        if issubclass(kind, OSError):  # its objects are larger than those of other exceptions
            return OSError.__new__(kind, message)
        return RuntimeError.__new__(kind, message)

    def __init__(self, message: str, code: str = "invalid_argument", opencl_code: int = 0) -> None:
        super().__init__(message)
        self.code = code
        self.opencl_code = opencl_code

    def __reduce__(self) -> tuple[Any, ...]:
        return Error, (str(self), self.code, self.opencl_code)


class InvalidArgument(Error, ValueError):
    """A clsdf.Error of the code 'invalid_argument', and a ValueError."""


class InvalidMesh(Error, ValueError):
    """A clsdf.Error of the code 'invalid_mesh', and a ValueError."""


class UnreadableInput(Error, OSError):
    """A clsdf.Error of the code 'unreadable_input', and an OSError."""


class OutputFailure(Error, OSError):
    """A clsdf.Error of the code 'output_failure', and an OSError."""


class OutOfMemory(Error, MemoryError):
    """A clsdf.Error of the code 'out_of_memory', and a MemoryError."""


class Unsupported(Error, ValueError):
    """A clsdf.Error of the code 'unsupported', and a ValueError: an ending of a file, an output that a format cannot store,
    a question that the mesh or the device does not answer."""


_kinds: dict[str, type[Error]] = {
    "invalid_argument": InvalidArgument,
    "invalid_mesh": InvalidMesh,
    "unreadable_input": UnreadableInput,
    "output_failure": OutputFailure,
    "out_of_memory": OutOfMemory,
    "unsupported": Unsupported,
}


class MeshWarning(UserWarning):
    """A property of the mesh that changes what is computed, for instance that it is open and the field has no sign; what
    was skipped in its file; points that are not finite; a band narrower than a voxel; what a file does not record."""
