"""The exception and the warning of the package."""

from __future__ import annotations


class Error(RuntimeError):
    """Every failure of clsdf. The message names the thing, the value and the remedy.

    code: the kind of the failure as text: 'invalid_mesh', 'unreadable_input', 'invalid_argument', 'no_device',
        'device_failure', 'out_of_memory', 'unsupported', 'cancelled', 'output_failure' or 'wrong_results'.
    opencl_code: the number that a failed call of OpenCL returned, else 0.
    """

    def __init__(self, message: str, code: str = "invalid_argument", opencl_code: int = 0) -> None:
        super().__init__(message)
        self.code = code
        self.opencl_code = opencl_code

    def __reduce__(self) -> tuple[type[Error], tuple[str, str, int]]:
        return Error, (str(self), self.code, self.opencl_code)


class MeshWarning(UserWarning):
    """A property of the mesh that changes what is computed, for instance that it is open and the field has no sign; what
    was skipped in its file; points that are not finite."""
