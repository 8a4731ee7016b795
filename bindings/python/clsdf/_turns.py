"""Processes that use a device for the first time compile one after the other: the first one compiles, and the others find
what it made. And a line on standard error says what takes long then."""

from __future__ import annotations

import os
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager

from . import _core
from ._progress import Progress, ProgressFunction, shown

#: Seconds that a process waits for another one; then it goes on by itself.
longest_wait = 30.0
#: Seconds of silence.
_silence = 2.0
_known: set[tuple[str, str]] = set()
#: A thread of this process has the turn, or waits for it. Others compile without, or they would wait for each other.
_is_taken = threading.Lock()


_said: set[str] = set()


def _say(text: str) -> None:
    """Writes a line, once a process."""
    if text in _said:
        return
    _said.add(text)
    try:
        sys.stderr.write(f"clsdf: {text}\n")
        sys.stderr.flush()
    except (AttributeError, OSError, ValueError):  # there is no standard error
        pass


class _Turn:
    """The lock of one call. It is taken when the call begins to compile, and given back when it ends, or when its process
    does."""

    def __init__(self, folder: str, device: str, is_silent: bool) -> None:
        self._folder, self._device, self._is_silent = folder, device, is_silent
        self._turn: _core.TurnToCompile | None = None
        self._line: threading.Timer | None = None
        self.has_compiled = self._is_holder = False

    def begin(self) -> None:
        self.has_compiled = True
        if not self._is_silent:
            text = f"compiling programs for {self._device}, once on this machine (progress=False: without this line)"
            self._line = threading.Timer(_silence, _say, (text,))
            self._line.daemon = True
        self._lock()
        if self._line is not None:
            self._line.start()

    def _lock(self) -> None:
        if not self._folder or not _is_taken.acquire(blocking=False):
            return
        self._is_holder = True
        self._turn = _core.TurnToCompile(self._folder, self._goes_on)

    def _goes_on(self, seconds: float) -> bool:
        """Asked while another process has the turn."""
        if seconds > _silence and not self._is_silent:
            _say(f"waiting for another process that compiles programs for {self._device}, {longest_wait:.0f} s at most")
        return seconds < longest_wait

    def end(self) -> None:
        if self._line is not None:
            self._line.cancel()
        self._turn = None
        if self._is_holder:
            _is_taken.release()


@contextmanager
def taken(progress: Progress, device: str, kind: str) -> Iterator[ProgressFunction | None]:
    """shown(), of a call on a device. The first call of a kind waits for another process that compiles, if it compiles
    itself. A process whose call was made on this machine before waits for nobody."""
    if (device, kind) in _known:
        with shown(progress) as show:
            yield show
        return
    folder = _core.default_record_folder()
    note = _note_of(folder, device, kind)
    if note and os.path.exists(note):
        _known.add((device, kind))
        with shown(progress) as show:
            yield show
        return
    turn = _Turn(folder, device, progress is not None)
    with shown(progress) as show:

        def watch(stage: str, fraction: float) -> object:
            if stage == "compiling" and not turn.has_compiled:
                turn.begin()
            return None if show is None else show(stage, fraction)

        try:
            yield watch
            if note and turn.has_compiled:
                _write(note)
            _known.add((device, kind))
        finally:
            turn.end()


def _note_of(folder: str, device: str, kind: str) -> str:
    """The file that says that a call of the kind was made on this machine."""
    if not folder:
        return ""
    import zlib

    number = zlib.crc32(f"{_core.version()}\n{device}\n{kind}".encode())
    return os.path.join(folder, f"{number:08x}.called")


def _write(note: str) -> None:
    try:
        os.close(os.open(note, os.O_WRONLY | os.O_CREAT | os.O_CLOEXEC, 0o600))
    except OSError:
        pass
