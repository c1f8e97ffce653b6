"""One file a group of bars: NAME, CASES, and `measure`, which returns the rows of one case."""

from __future__ import annotations

from reference_tracer.errors import InputError

from . import (
    exact_vs_paper,
    exact_vs_port,
    first_hits,
    first_picture,
    mitsuba_mesh,
    objects,
    paper_vs_port,
    povray_isosurface,
    povray_native,
    resolution,
    threads,
)

GROUPS = {group.NAME: group for group in (
    paper_vs_port, exact_vs_port, exact_vs_paper, povray_isosurface, povray_native, mitsuba_mesh, threads, resolution,
    objects, first_picture, first_hits)}


def find(names: list[str]) -> list:
    """The groups called `names`, all of them if none is given. Raises InputError."""
    for name in names:
        if name not in GROUPS:
            raise InputError(f"unknown group {name!r}; choose among {', '.join(GROUPS)}")
    return [GROUPS[name] for name in names] if names else list(GROUPS.values())
