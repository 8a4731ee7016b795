"""`python -m clsdf.pkgconfig` prints the folder of clsdf's descriptions for pkg-config: PKG_CONFIG_PATH=..."""

from __future__ import annotations

import sys

from ._prefix import print_folder

if __name__ == "__main__":
    sys.exit(print_folder("lib", "pkgconfig"))
