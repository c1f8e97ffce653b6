"""Every limit that decides a verdict: its value, its unit, and where it comes from.

A derived limit follows from a formula; a measured one is what a command shows, with room to the next worse setting, which
the same command holds against it (its rows "tight" and "loose").
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import astuple, dataclass
from typing import Literal

from ..results import Run

AT_SIZE = 640 * 480
MEASURED = "raytruth compare"


@dataclass(frozen=True)
class Limit:
    name: str
    value: float
    unit: str
    origin: Literal["derived", "measured"]
    by: str  # the formula, or the command


@dataclass(frozen=True)
class Tolerance:
    """How far a kind of renderer may be from the truth, and why so far."""

    name: str
    because: str
    depth_p99: float  # relative
    color_p99: float
    # of all pixels of a picture of AT_SIZE; edges are lines, so that their pixels grow with its side, not with its area
    failing_share: float  # edges seen directly, in mirrors and through glass fall on other pixels
    clustered_share: float  # whole neighbourhoods that fail are no edges
    mismatch_share: float  # hit/miss or object, at silhouettes

    @staticmethod
    def allowed(share: float, pixels: int) -> int:
        """A share as a number of pixels, in a picture of that many."""
        return round(share * (pixels * AT_SIZE) ** 0.5)


NATIVE = Tolerance("native shapes", "single precision, and ray origins offset by a unit of it",
                   depth_p99=5e-7, color_p99=2e-6, failing_share=2e-4, clustered_share=1e-5, mismatch_share=2e-4)
MESH = Tolerance("meshes", "surfaces replaced by triangles, error falling with the square of the resolution",
                 depth_p99=1e-4, color_p99=1e-3, failing_share=2e-3, clustered_share=1e-5, mismatch_share=2.5e-4)
GRID = Tolerance("grids", "f replaced by its trilinear interpolation, error falling with the square of the cells",
                 depth_p99=3e-4, color_p99=1e-2, failing_share=3e-2, clustered_share=2e-3, mismatch_share=5e-3)
TRACERS = Tolerance("two tracers of one mesh", "the triangles are the same; what is left is single precision",
                    depth_p99=5e-7, color_p99=3e-5, failing_share=4e-4, clustered_share=1e-5, mismatch_share=2.5e-4)
ORACLE = Tolerance("POV-Ray", "double precision, colours of 16 bits",
                   depth_p99=1e-10, color_p99=2e-5, failing_share=1e-3, clustered_share=0, mismatch_share=1e-3)
DOUBLE = Tolerance("double precision", "the same model in double precision",
                   depth_p99=1e-9, color_p99=1e-9, failing_share=0, clustered_share=0, mismatch_share=0)

# of an oracle's every pixel, with primitives: a step of 16 bits, 2^-16 = 1.5e-5, and the rounding of what is added to it;
# with isosurfaces at accuracy 1e-8 what their normals, differences over that distance, are off by
ANALYTICAL, NUMERICAL = 2e-5, 2e-4
ON_EDGES = 0.25  # of a picture's side: the rooms of figures 10 to 16 have edges through the centres of 107 pixels
REPEATED = 1e-9  # of every plane of a pixel that two programs compute in double precision by the same method


def tolerance_of(run: Run) -> Tolerance:
    """How far a run may be from the truth. Where a renderer has no exact shape for a surface, triangles stand for it."""
    if run.renderer in ("exact", "paper"):
        return DOUBLE
    if run.renderer.startswith("povray"):
        return ORACLE
    if run.facts.get("grids"):
        return GRID
    # hits on triangles may have been moved onto the surface they stand for
    return MESH if run.facts.get("triangles") and not run.facts.get("refined") else NATIVE


def between(first: Run, second: Run) -> Tolerance:
    """How far two runs may be from each other: each may be as far from the truth as its own tolerance says."""
    a, b = tolerance_of(first), tolerance_of(second)
    if a is b is MESH and _mesh(first) == _mesh(second):
        return TRACERS
    if DOUBLE in (a, b):
        return b if a is DOUBLE else a
    name = f"{a.name}, both" if a is b else f"{a.name} and {b.name}"
    return Tolerance(name, "each may be as far from the truth as its own tolerance says",
                     *(x + y for x, y in zip(astuple(a)[2:], astuple(b)[2:])))


def _mesh(run: Run):
    """What tells the meshes of a run apart from those of another."""
    return run.facts.get("triangles"), run.settings.get("resolution"), run.facts.get("native_shapes", 0)


def largest_difference(run: Run) -> float | None:
    """How far any pixel of an oracle's picture may be from the truth unless rounding excuses it; None for other runs.

    Colours are in units of the brightest possible one: 16 bits tell no more of it.
    """
    if tolerance_of(run) is not ORACLE:
        return None
    return (NUMERICAL if run.facts.get("isosurfaces") else ANALYTICAL) * max(1.0, run.facts.get("brightest", 1.0))


def unmeasured(run: Run) -> str:
    """Why a picture that keeps every limit proves nothing; "" where it does."""
    if run.facts.get("measured_mesh_error", 0) is None:
        return "every limit holds, but how far its meshes are from the surfaces is not measurable"
    return ""


def table() -> Iterator[Limit]:
    """All limits."""
    units = {"depth_p99": "relative", "color_p99": "linear", "failing_share": "of the pixels at 640 x 480",
             "clustered_share": "of the pixels at 640 x 480", "mismatch_share": "of the pixels at 640 x 480"}
    for tolerance in (NATIVE, MESH, GRID, TRACERS, ORACLE, DOUBLE):
        for name, unit in units.items():
            yield Limit(f"{tolerance.name}: {name}", getattr(tolerance, name), unit, "measured", MEASURED)
    yield Limit("POV-Ray: colour, primitives", ANALYTICAL, "of the brightest colour", "derived", "2^-16 and its rounding")
    yield Limit("POV-Ray: colour, isosurfaces", NUMERICAL, "of the brightest colour", "measured",
                "raytruth compare --renderers povray-isosurface")
    yield Limit("excused pixels, undecided pixels", ON_EDGES, "of the picture's side", "measured",
                "raytruth compare figure-10-refraction-n0.8 --renderers povray")
    yield Limit("literal method: every plane", REPEATED, "relative", "measured",
                "raytruth compare --renderers paper")
