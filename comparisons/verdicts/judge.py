"""From numbers to a verdict. A picture agrees when every gate holds; no score of the whole image can stand in for one."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import astuple, dataclass

from ..results import Gate, Run, Verdict


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


AT_SIZE = 640 * 480
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

ANALYTICAL, NUMERICAL = 2e-5, 2e-4  # of an oracle's every pixel: with primitives, with isosurfaces at accuracy 1e-8
EXCUSED_EDGES = 0.25  # of a picture's side: the rooms of figures 10 to 16 have edges through the centres of 107 pixels


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


def excuses(metrics: dict[str, float | int | None], limit: float) -> list[Gate]:
    """The gates of an oracle's picture."""
    return [_gate("color max not excused", metrics["color max not excused"], limit, "linear",
                  "the largest error of colour of all pixels that rounding alone does not decide"),
            _gate("excused pixels", metrics["excused pixels"], round(EXCUSED_EDGES * metrics["pixels"] ** 0.5), "pixels",
                  "pixels beyond that limit whose colour hangs on rounding: edges that run through a pixel's centre")]


def judge(metrics: dict[str, float | int | None], tolerance: Tolerance,
          more: Sequence[Gate] = ()) -> tuple[Verdict, str, list[Gate]]:
    """The verdict on one comparison, the reason in one sentence, and the gates behind it, `more` of them first."""
    pixels = metrics["pixels"]
    gates = [
        *more,
        _gate("not finite", metrics["not finite"], 0, "pixels", "pixels whose colour is NaN or infinite on either side"),
        _gate("interior mismatches", metrics["interior mismatches"], 0, "pixels",
              "pixels away from silhouettes where another object, or none, was hit"),
        _gate("object mismatches", metrics["object mismatches"], tolerance.allowed(tolerance.mismatch_share, pixels), "pixels",
              "pixels where another object, or none, was hit; silhouettes included"),
        _gate("depth p99", metrics["depth p99"], tolerance.depth_p99, "relative",
              "99 % of interior pixels have a smaller relative error of depth"),
        _gate("color p99", metrics["color p99"], tolerance.color_p99, "linear",
              "99 % of all pixels have a smaller error of colour"),
        _gate("failing pixels", metrics["failing pixels"], tolerance.allowed(tolerance.failing_share, pixels), "pixels",
              "pixels off by more than one step of an 8-bit picture"),
        _gate("clustered failing pixels", metrics["clustered failing pixels"],
              tolerance.allowed(tolerance.clustered_share, pixels), "pixels", "failing pixels whose eight neighbours fail too: a region is wrong, not an edge"),
    ]
    broken = [gate for gate in gates if not gate.holds]
    if broken:
        worst = broken[0]
        others = {0: "", 1: "; one more limit is exceeded"}.get(
            len(broken) - 1, f"; {len(broken) - 1} more limits are exceeded")
        return "differs", f"{worst.name} is {_shown(worst.value)}, {_shown(worst.limit)} is allowed{others}", gates
    return "agrees", f"every limit for {tolerance.name} holds ({tolerance.because})", gates


def _gate(name: str, value, limit: float, unit: str, means: str) -> Gate:
    # nothing to compare (no pixel hit, say) breaks no gate; NaN breaks every one
    return Gate(name=name, value=value, limit=limit, holds=value is None or value <= limit, unit=unit, means=means)


def _shown(value) -> str:
    return "nothing" if value is None else f"{value:d}" if isinstance(value, int) else f"{value:.3g}"
