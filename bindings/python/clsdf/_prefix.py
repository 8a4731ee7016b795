"""The installation of clsdf for C++, C and Fortran that a wheel has: bin, lib, include and share in the package's folder."""

from __future__ import annotations

import sys
from pathlib import Path

from . import _core


def prefix() -> Path:
    """The folder of the installation. Raises FileNotFoundError if the package has none."""
    folder = Path(_core.__file__).resolve().parent
    if not (folder / "lib" / "cmake" / "clsdf").is_dir():
        raise FileNotFoundError(
            f"{folder} has no libraries for C++, C and Fortran: a package that is built from a clone has none. A wheel of "
            "scripts/wheel has them; `cmake --install` of the library itself installs them without Python"
        )
    return folder


def print_folder(*below: str) -> int:
    """Prints the folder `below` the prefix, for scripts. Returns the exit status."""
    try:
        print(prefix().joinpath(*below))
    except FileNotFoundError as error:
        print(f"clsdf: {error}", file=sys.stderr)
        return 1
    return 0
