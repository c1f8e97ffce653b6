"""Numbers and vectors as POV-Ray's scene description language (SDL) writes them: every digit of a double, nothing else."""

from __future__ import annotations


def number(x) -> str:
    """A finite number, so that reading it back gives the same double."""
    return repr(float(x))


def vector(values) -> str:
    return "<" + ",".join(map(number, values)) + ">"
