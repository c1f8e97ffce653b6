"""From numbers to a verdict. A picture agrees when every gate holds; no score of the whole image can stand in for one."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from ..results import Gate, Verdict
from .tolerances import ON_EDGES, Tolerance

Metrics = Mapping[str, float | int | None]


def excuses(metrics: Metrics, limit: float) -> list[Gate]:
    """The gates of an oracle's picture."""
    return [_gate("color max not excused", metrics["color max not excused"], limit, "linear",
                  "the largest error of colour of all pixels that rounding alone does not decide"),
            _gate("excused pixels", metrics["excused pixels"], _on_edges(metrics), "pixels",
                  "pixels beyond that limit whose colour hangs on rounding: edges that run through a pixel's centre")]


def literal(metrics: Metrics, step_size: float) -> tuple[Verdict, str, list[Gate]]:
    """The verdict on the literal method: a fault where its oracle shows something else; where both differ from exact
    intersections, that is its nature."""
    asked, wrong = metrics["oracle pixels"], metrics["differing pixels"]
    gates = [_gate("oracle mismatches", metrics["oracle mismatches"], 0, "pixels",
                   f"of {asked} pixels asked for, those on which the recursive tracer shows another object, distance or colour"),
             _gate("oracle excused pixels", metrics["oracle excused pixels"], _on_edges(metrics), "pixels",
                   "pixels on which the two differ by no more than rounding may change")]
    if broken := [gate for gate in gates if not gate.holds]:
        return "differs", (f"{broken[0].name}: {broken[0].value} of {asked} pixels, {broken[0].limit:g} allowed; they differ "
                           f"by up to {metrics['oracle color max']:.3g}"), gates
    if not wrong:
        return "agrees", (f"at step size {step_size:g} the literal method shows what exact intersections show; its oracle "
                          f"agrees on all {asked} pixels asked for"), gates
    reasons = sorted(((count, name.removeprefix("cause: ")) for name, count in metrics.items() if name.startswith("cause: ")),
                     reverse=True)
    told = ", ".join(f"{count} {name}" for count, name in reasons)
    return "expected", (f"{wrong} pixels differ from exact intersections; of {metrics['differing pixels asked']} of them the "
                        f"oracle shows the same at step size {step_size:g}: {told}"), gates


def _on_edges(metrics: Metrics) -> int:
    return round(ON_EDGES * metrics["pixels"] ** 0.5)


def judge(metrics: Metrics, tolerance: Tolerance,
          more: Sequence[Gate] = ()) -> tuple[Verdict, str, list[Gate]]:
    """The verdict on one comparison, the reason in one sentence, and the gates behind it, `more` of them first."""
    pixels = metrics["pixels"]
    gates = [
        *more,
        _gate("undecided pixels", metrics["undecided pixels"], _on_edges(metrics), "pixels",
              "pixels that the reference itself leaves open: they judge nobody, so that they must be few"),
        _gate("not finite", metrics["not finite"], 0, "pixels", "pixels whose colour is NaN or infinite on either side"),
        _gate("interior mismatches", metrics["interior mismatches"], 0, "pixels",
              "pixels away from silhouettes where another object, or none, was hit"),
        _gate("object mismatches", metrics["object mismatches"], tolerance.allowed(tolerance.mismatch_share, pixels), "pixels",
              "pixels where another object, or none, was hit; silhouettes included"),
        _gate("depth p99", metrics["depth p99"], tolerance.depth_p99, "relative",
              "99 % of interior pixels have a smaller relative error of depth", none=not metrics["interior hit pixels"]),
        _gate("color p99", metrics["color p99"], tolerance.color_p99, "linear",
              "99 % of all pixels have a smaller error of colour"),
        _gate("failing pixels", metrics["failing pixels"], tolerance.allowed(tolerance.failing_share, pixels), "pixels",
              "pixels off by more than one step of an 8-bit picture"),
        _gate("clustered failing pixels", metrics["clustered failing pixels"],
              tolerance.allowed(tolerance.clustered_share, pixels), "pixels",
              "failing pixels whose eight neighbours fail too: a region is wrong, not an edge"),
    ]
    broken = [gate for gate in gates if not gate.holds]
    if broken:
        worst = broken[0]
        others = {0: "", 1: "; one more limit is exceeded"}.get(
            len(broken) - 1, f"; {len(broken) - 1} more limits are exceeded")
        return "differs", f"{worst.name} is {_shown(worst.value)}, {_shown(worst.limit)} is allowed{others}", gates
    return "agrees", f"every limit for {tolerance.name} holds ({tolerance.because})", gates


def _gate(name: str, value, limit: float, unit: str, means: str, none: bool = False) -> Gate:
    # NaN breaks every gate, and so does None, unless there was nothing to be measured: then `none` is true
    return Gate(name=name, value=value, limit=limit, holds=none if value is None else bool(value <= limit), unit=unit,
                means=means)


def _shown(value) -> str:
    return "nothing" if value is None else f"{value:d}" if isinstance(value, int) else f"{value:.3g}"
