"""The memory that new arrays may take, so that the kernel does not end the process for them."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from ._error import Error


def _number(path: Path) -> int | None:
    try:
        return int(path.read_text())
    except (OSError, ValueError):  # "max": no limit
        return None


def _groups(proc: Path, root: Path) -> Iterator[tuple[Path, str, str]]:
    """The folders of this process's groups, up to the root, with the names of their limit and their use."""
    try:
        lines = (proc / "self" / "cgroup").read_text().splitlines()
    except OSError:
        return
    for line in lines:
        _, controllers, path = line.split(":", 2)
        if controllers and "memory" not in controllers.split(","):
            continue
        names = ("memory.limit_in_bytes", "memory.usage_in_bytes") if controllers else ("memory.max", "memory.current")
        top = root / "memory" if controllers else root
        folder = top / path.lstrip("/")
        while True:
            yield folder, *names
            if folder == top or folder == folder.parent:
                break
            folder = folder.parent


def _cached(folder: Path) -> int:
    """Bytes of files that the kernel gives back when memory is short."""
    try:
        rows = dict(line.split() for line in (folder / "memory.stat").read_text().splitlines())
        return int(rows.get("total_inactive_file", rows.get("inactive_file", "0")))
    except (OSError, ValueError):
        return 0


def available(proc: Path = Path("/proc"), root: Path = Path("/sys/fs/cgroup")) -> int | None:
    """Bytes that this process may take: MemAvailable, and what the limits of its cgroup leave. None if Linux does not
    say."""
    rooms = []
    try:
        for line in (proc / "meminfo").read_text().splitlines():
            if line.startswith("MemAvailable:"):
                rooms.append(1024 * int(line.split()[1]))
    except (OSError, ValueError):
        pass
    for folder, limit_name, use_name in _groups(proc, root):
        limit, use = _number(folder / limit_name), _number(folder / use_name)
        if limit is not None and use is not None:
            rooms.append(max(0, limit - max(0, use - _cached(folder))))
    return min(rooms, default=None)


def check(size: int, what: str) -> None:
    """Raises clsdf.Error (out_of_memory) if new arrays of `size` bytes exceed what is available."""
    room = available()
    if room is not None and size > room:
        raise Error(
            f"{what} of {size / 1e9:.1f} GB does not fit the memory, of which {room / 1e9:.1f} GB are available; choose "
            "a lower resolution, fewer outputs, or slabs(), or pass arrays of your own as out=",
            "out_of_memory",
        )
