"""`python -m clsdf.cmake` prints the prefix for CMake's find_package(clsdf): cmake -DCMAKE_PREFIX_PATH=..."""

from __future__ import annotations

import sys

from ._prefix import print_folder

if __name__ == "__main__":
    sys.exit(print_folder())
