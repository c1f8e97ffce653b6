"""Peak memory of this process alone: the kernel's ru_maxrss would begin with what the parent held when it forked."""

from __future__ import annotations

import contextlib


def peak_kib() -> int:
    """The most that was resident since the start, or since `forget_peak`."""
    with open("/proc/self/status", encoding="ascii") as file:
        return next(int(line.split()[1]) for line in file if line.startswith("VmHWM"))


def forget_peak() -> None:
    """Lets the peak begin anew with what is resident now, where the kernel allows it."""
    with contextlib.suppress(OSError), open("/proc/self/clear_refs", "w", encoding="ascii") as file:
        file.write("5")
