"""Files that appear when they are complete, or not at all."""

from __future__ import annotations

import os
import threading
from collections.abc import Callable

from ._error import Error


def complete(path: str, ending: str, write: Callable[[str], None]) -> None:
    """Gives a file its name when `write` has written it, under another name with the ending. Raises clsdf.Error
    (output_failure)."""
    target = os.path.realpath(path)  # a link stays one
    folder, name = os.path.split(target)
    unfinished = os.path.join(folder, f".{name}.{os.getpid()}.{threading.get_native_id()}{ending}")
    try:
        try:
            write(unfinished)
            os.replace(unfinished, target)
        except BaseException:
            if os.path.exists(unfinished):
                os.remove(unfinished)
            raise
    except OSError as error:
        raise Error(f"{path} cannot be written: {error.strerror}", "output_failure") from error
