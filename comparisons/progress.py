"""A progress bar with the time left; silent where nobody watches."""

from __future__ import annotations

import sys
import time


class Progress:
    """`step` counts finished work, `show` redraws. Draws on stderr, only on a terminal."""

    def __init__(self, total: float, quiet: bool = False, label: str = ""):
        self.total, self.done, self.label = max(total, 1e-9), 0.0, label
        self.start = time.monotonic()
        self.visible = sys.stderr.isatty() and not quiet

    def step(self, amount: float = 1, label: str = "") -> None:
        self.done += amount
        self.show(label)

    def to(self, done: float) -> None:
        self.done = done
        self.show()

    def show(self, label: str | None = None) -> None:
        self.label = self.label if label is None else label
        if not self.visible:
            return
        share = min(self.done / self.total, 1)
        elapsed = time.monotonic() - self.start
        left = f"{_clock(elapsed / share - elapsed)} left" if share > 0.02 else "estimating"
        filled = round(24 * share)
        sys.stderr.write(f"\r\x1b[2K[{'#' * filled}{'.' * (24 - filled)}] {share:4.0%}  {left}  {self.label[:60]}")
        sys.stderr.flush()

    def close(self) -> None:
        if self.visible:
            sys.stderr.write("\r\x1b[2K")
            sys.stderr.flush()


def _clock(seconds: float) -> str:
    return f"{int(seconds) // 60}:{int(seconds) % 60:02d}"
