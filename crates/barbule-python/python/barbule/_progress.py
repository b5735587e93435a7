"""Progress with the time left, in terminals and notebooks."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from typing import Any, Union

#: What `progress=` takes: True or False, or a function `(label, done, total)` that may raise to stop the work.
ProgressLike = Union[bool, Callable[[str, int, int], Any]]

#: Work that ends sooner shows nothing, s.
SOON_S = 2.0


class Bar:
    """A line with the part that is done and the time left; nothing for the first two seconds, nothing where nobody looks.

    It writes to standard error where that is a terminal or a notebook's output.

    Example:
        >>> import barbule
        >>> bar = barbule.Bar()
        >>> bar("simulating", 3, 10)
    """

    def __init__(self) -> None:
        self._began = time.monotonic()
        self._stage = ""
        self._stage_began = self._began
        self._shown = 0

    def __call__(self, label: str, done: int, total: int) -> None:
        """Shows that `done` of `total` steps of a stage are done."""
        now = time.monotonic()
        if label != self._stage:
            self._stage, self._stage_began = label, now
        if now - self._began < SOON_S or not _somebody_looks():
            return
        text = f"{label}: {100 * done // max(total, 1)} %"
        if 0 < done < total:
            left = (now - self._stage_began) * (total - done) / done
            text += f", {_duration(left)} left"
        self._write(text)

    def close(self) -> None:
        """Takes the line away."""
        if self._shown:
            self._write("")
            sys.stderr.write("\r")
            sys.stderr.flush()

    def _write(self, text: str) -> None:
        sys.stderr.write("\r" + text.ljust(self._shown))
        sys.stderr.flush()
        self._shown = len(text)


def _duration(seconds: float) -> str:
    if seconds < 90:
        return f"{max(seconds, 1):.0f} s"
    return f"{seconds / 60:.0f} min" if seconds < 5400 else f"{seconds / 3600:.1f} h"


def _somebody_looks() -> bool:
    return sys.stderr.isatty() or type(sys.stderr).__module__.startswith("ipykernel")


class watched:
    """Gives the native module what `progress=` asks for, and takes the bar away afterwards."""

    def __init__(self, progress: ProgressLike) -> None:
        self._bar = Bar() if progress is True else None
        self._own = progress if callable(progress) else None

    def __enter__(self) -> Callable[[str, int, int], Any] | None:
        return self._own or self._bar

    def __exit__(self, *_: object) -> None:
        if self._bar is not None:
            self._bar.close()
