"""progress=True: a bar of tqdm if it is installed, else a line on standard error."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Union

ProgressFunction = Callable[[str, float], object]
Progress = Union[bool, ProgressFunction, None]


@contextmanager
def shown(progress: Progress) -> Iterator[ProgressFunction | None]:
    """The function that a call gets."""
    if progress is None or progress is False:
        yield None
    elif progress is True:
        bar = _bar()
        try:
            yield bar.show
        finally:
            bar.close()
    else:
        yield progress


class _Line:
    """The stage and the percent, written over each other."""

    def __init__(self) -> None:
        self._text = ""

    def show(self, stage: str, fraction: float) -> None:
        text = f"{stage} {100 * fraction:3.0f}%"
        if text != self._text:
            sys.stderr.write(f"\r{text:<20}")
            sys.stderr.flush()
            self._text = text

    def close(self) -> None:
        if self._text:
            sys.stderr.write("\r" + " " * 20 + "\r")
            sys.stderr.flush()


class _Tqdm:
    def __init__(self, bar: object) -> None:
        self._bar: object = bar
        self._stage = ""

    def show(self, stage: str, fraction: float) -> None:
        bar: object = self._bar
        if stage != self._stage:
            self._stage = stage
            bar.set_description(stage)  # type: ignore[attr-defined]
        bar.update(100 * fraction - bar.n)  # type: ignore[attr-defined]

    def close(self) -> None:
        self._bar.close()  # type: ignore[attr-defined]


def _bar() -> _Line | _Tqdm:
    try:
        from tqdm.auto import tqdm  # type: ignore[import-untyped,import-not-found,unused-ignore]
    except ImportError:
        return _Line()
    return _Tqdm(tqdm(total=100, bar_format="{desc} {percentage:3.0f}%|{bar}| {elapsed}", leave=False))
