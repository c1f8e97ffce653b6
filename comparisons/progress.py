"""How far the work is: a bar on a terminal (rich), a line now and then where nobody watches one. Both on stderr.

A thread of its own keeps time, so that long silent work (one kernel being compiled) still shows that it goes on.
"""

from __future__ import annotations

import sys
import threading
import time
from datetime import UTC, datetime
from pathlib import Path

from . import times

STEADY, WILD = 1.5, 10.0  # paces that differ by more are a range, and no more than a least time
NOTHING = 1e-9  # units of work: none is expected yet
EVERY = 5.0  # seconds between two lines where no terminal watches; work done sooner says nothing


class Progress:
    """Work of `total` units: `step` counts what is finished, `to` tells where it stands, `log` prints a line of its own.

    Safe to call from any thread. `close` ends the display; whatever comes later starts it again. `quiet` shows nothing.
    """

    def __init__(self, total: float, quiet: bool = False, label: str = ""):
        self.total, self.done, self.label = max(total, NOTHING), 0.0, label
        self._start = self._moved = time.monotonic()
        self._marks: list[tuple[float, float]] = []  # when how much was done, a hundred at most
        self._terminal, self._quiet = sys.stderr.isatty(), quiet
        self._lock = threading.RLock()
        self._display: _Bar | _Lines | None = None
        self.show()

    def step(self, amount: float = 1, label: str | None = None) -> None:
        with self._lock:
            self.to(self.done + amount, label)

    def to(self, done: float, label: str | None = None) -> None:
        with self._lock:
            if done != self.done:
                self.done, self._moved = done, time.monotonic()
                if done > (self._marks[-1][1] if self._marks else 0.0) + 0.01 * self.total:
                    self._marks.append((self._moved, done))
            self.show(label)

    def show(self, label: str | None = None) -> None:
        with self._lock:
            self.label = self.label if label is None else label
            if self._quiet or not (self.label or self.total > NOTHING):
                return
            if self._display is None:
                self._display = _Bar(self) if self._terminal else _Lines(self)
            self._display.update()

    def log(self, line: str) -> None:
        """A line that stays, above the bar: a finished case, an estimate."""
        with self._lock:
            if self._display:
                self._display.log(line)
            elif not self._quiet:
                print(line, file=sys.stderr, flush=True)

    def close(self) -> None:
        with self._lock:
            display, self._display = self._display, None
        if display:
            display.close()

    def __enter__(self) -> Progress:
        return self

    def __exit__(self, *_) -> None:
        self.close()

    @property
    def line(self) -> str:
        """Where the work stands, in words."""
        now = time.monotonic()
        share, elapsed = min(self.done / self.total, 1.0), now - self._start
        known = share > 0.02 and now - self._moved < 2 * EVERY  # what stands still tells nothing
        left = f", {self._left(now)} left" if known else ""
        return f"{self.label + ': ' if self.label else ''}{share:.0%} after {_clock(elapsed)}{left}"

    def _left(self, now: float) -> str:
        """The time that the rest takes, at the pace of all that was done and at that of the latter half of the time."""
        at, then = [mark for mark in ((self._start, 0.0), *self._marks) if mark[0] <= (self._start + now) / 2][-1]
        rest = max(self.total - self.done, 0.0)
        paces = (now - self._start) / self.done, (now - at) / max(self.done - then, 1e-9)
        low, high = min(paces), max(paces)
        if high > WILD * low:  # nothing was finished of late, or nothing before
            return f"more than {_clock(rest * low)}"
        return f"{_clock(rest * low)} to {_clock(rest * high)}" if high > STEADY * low else f"about {_clock(rest * paces[0])}"


class Cases(Progress):
    """The cases of a pool: a bar, and where no terminal watches a line for every case that has ended.

    What they took is kept in the `folder`, if there is one, as that of the `suite`: see times.py.
    """

    def __init__(self, suite: str = "", folder: Path | None = None):
        super().__init__(0)
        self._suite, self._folder = suite, folder
        self._created, self._spent = datetime.now(UTC).isoformat(timespec="seconds"), []

    def expect(self, cases: int) -> None:
        with self._lock:
            self.total = cases if self.total < 1 else self.total + cases
            if cases:
                self.show()

    def begin(self, label: str, share: float = 0.0) -> None:
        self.show(f"{label}, {share:.0%}" if share else label)

    def end(self, label: str, seconds: float, state: str) -> None:
        with self._lock:
            self.step(1, label)
            self._spent.append((label, round(seconds, 2)))
            if not self._terminal:
                self.log(f"{label}: {state}, {seconds:.1f} s ({self.done:.0f} of {self.total:.0f})")
            if self.done >= self.total:
                self.close()

    def __exit__(self, failed, *_) -> None:
        self.close()
        if failed is None and self._folder and self._folder.is_dir():
            times.keep(times.Suite(name=self._suite, created=self._created, cases=self._spent,
                                   seconds=round(time.monotonic() - self._start, 1)), self._folder)


class _Bar:
    """On a terminal. It vanishes when it is closed."""

    def __init__(self, progress: Progress):
        from rich.console import Console
        from rich.progress import BarColumn, Progress, TaskProgressColumn, TextColumn, TimeElapsedColumn, TimeRemainingColumn

        self._progress = progress
        columns = (BarColumn(24), TaskProgressColumn(), TimeElapsedColumn(), TextColumn("left:"), TimeRemainingColumn(),
                   TextColumn("{task.description}", markup=False))
        self._bar = Progress(*columns, console=Console(stderr=True, highlight=False), transient=True,
                             refresh_per_second=5, redirect_stdout=False, redirect_stderr=False)
        self._task = self._bar.add_task(progress.label, total=progress.total, completed=progress.done)
        self._bar.start()

    def update(self) -> None:
        self._bar.update(self._task, total=self._progress.total, completed=self._progress.done,
                         description=self._progress.label[:60])

    def log(self, line: str) -> None:
        self._bar.console.print(line, markup=False, soft_wrap=True)

    def close(self) -> None:
        self._bar.stop()


class _Lines:
    """Where no terminal watches: a line every EVERY seconds, from a thread that ends with the display or the process."""

    def __init__(self, progress: Progress):
        self._progress, self._closed = progress, threading.Event()
        threading.Thread(target=self._talk, daemon=True, name="progress").start()

    def _talk(self) -> None:
        while not self._closed.wait(EVERY):
            self.log(self._progress.line)

    def update(self) -> None:
        pass

    def log(self, line: str) -> None:
        print(line, file=sys.stderr, flush=True)

    def close(self) -> None:
        self._closed.set()


def _clock(seconds: float) -> str:
    minutes, seconds = divmod(int(seconds), 60)
    hours, minutes = divmod(minutes, 60)
    return f"{hours}:{minutes:02d}:{seconds:02d}" if hours else f"{minutes}:{seconds:02d}"
