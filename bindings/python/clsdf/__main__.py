"""python -m clsdf: the command clsdf, if the package has it. The wheel of scripts/wheel does."""

from __future__ import annotations

import os
import sys
from pathlib import Path


def main() -> None:
    command = Path(__file__).parent / "bin" / "clsdf"
    if not command.is_file():
        sys.exit("this package of clsdf has no command: the wheel that scripts/wheel makes has one, and so has the build of "
                 "docs/install.md")
    os.execv(command, [str(command), *sys.argv[1:]])


if __name__ == "__main__":
    main()
