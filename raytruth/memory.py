"""How much memory a command may take: told and refused before the work, never found out in the middle of it."""

from __future__ import annotations

from collections.abc import Sequence

from raytruth.reference_tracer.errors import InputError

GIB = 1 << 30
UNASKED = 2.0  # GiB that a command may take without being allowed more


def add_argument(parser) -> None:
    from .arguments import number

    parser.add_argument("--memory", type=number(0.1, 1024), metavar="GIB",
                        help=f"the most memory to take (default {UNASKED:g}, or what is there if that is less)")


def require(scene, planes: Sequence[str], beside: int, most: float | None) -> None:
    """Raises InputError where a picture of `scene` takes more memory than there is, or than `most` GiB.

    `beside` are the bytes that the command takes for a pixel beside the picture's planes.
    """
    from raytruth.reference_tracer.tracer.estimate import available, memory, size_of

    needed, there = memory(scene, planes, beside), available()
    limit = min(UNASKED * GIB, there) if most is None else most * GIB
    if needed > limit:
        room = f"more than {size_of(limit)}" if needed <= there else f"and {size_of(there)} are there"
        remedy = f"take more by --memory {needed / GIB + 0.05:.1f}, or less" if needed <= there else "take less"
        raise InputError(f"{scene.name}: this takes about {size_of(needed)} of memory, {room}; {remedy} by a smaller picture "
                         "or fewer objects")
