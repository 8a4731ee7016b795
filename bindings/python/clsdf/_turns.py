"""Processes that use a device for the first time compile one after the other: the first one compiles, and the others find
what it made. And a line on standard error says what takes long then."""

from __future__ import annotations

import os
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager

from . import _core
from ._progress import Progress, ProgressFunction, shown

#: Seconds that a process waits for another one; then it goes on by itself.
longest_wait = 30.0
#: Seconds of silence.
_silence = 2.0
#: File systems of one machine, which have locks: those of docs/formats.md, 'Unfinished files'.
_local = {"ext2", "ext3", "ext4", "xfs", "btrfs", "f2fs", "zfs", "bcachefs", "tmpfs", "overlay"}

_known: set[tuple[str, str]] = set()
#: A thread of this process has the turn, or waits for it. Others compile without, or they would wait for each other.
_is_taken = threading.Lock()


def folder_of_records() -> str:
    """Device::default_record_folder() of C++; empty if there is none."""
    named = os.environ.get("CLSDF_CACHE_DIR")
    if named is not None:
        return os.path.abspath(named) if named else ""
    cache, home = os.environ.get("XDG_CACHE_HOME"), os.environ.get("HOME")
    if cache:
        return os.path.join(cache, "clsdf")
    return os.path.join(home, ".cache", "clsdf") if home else ""


def _is_local(folder: str) -> bool:
    """Whether the folder is on a file system of this machine that is known to have locks."""
    path, best, kind = os.path.realpath(folder), "", ""
    try:
        with open("/proc/self/mountinfo") as mounts:
            for line in mounts:
                before, _, after = line.partition(" - ")
                point = before.split()[4].replace("\\040", " ")
                if (path == point or path.startswith(point.rstrip("/") + "/")) and len(point) >= len(best):
                    best, kind = point, after.split()[0]
    except (OSError, IndexError):
        return False
    return kind in _local


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
        self._file: int | None = None
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
        import fcntl

        try:
            os.makedirs(self._folder, exist_ok=True)
            file = os.open(os.path.join(self._folder, "compiling.lock"), os.O_RDWR | os.O_CREAT | os.O_CLOEXEC, 0o600)
        except OSError:
            return
        began, has_told = time.monotonic(), self._is_silent
        while True:
            try:
                fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
                self._file = file
                return
            except BlockingIOError:
                waited = time.monotonic() - began
            except OSError:
                break
            if waited > longest_wait:
                break
            if waited > _silence and not has_told:
                has_told = True
                _say(f"waiting for another process that compiles programs for {self._device}, {longest_wait:.0f} s at most")
            time.sleep(0.02)
        os.close(file)

    def end(self) -> None:
        if self._line is not None:
            self._line.cancel()
        if self._file is not None:
            os.close(self._file)
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
    folder = folder_of_records()
    if folder and not _is_local(folder):
        folder = ""
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
