"""From numbers to a verdict. A picture agrees when every gate holds; no score of the whole image can stand in for one."""

from __future__ import annotations

from collections.abc import Mapping

from raytruth.reference_tracer.tracer.sensitivity import PROBES

from ..results import Gate, Verdict
from .tolerances import Tolerance

Metrics = Mapping[str, float | int | None]


def literal(metrics: Metrics, step_size: float) -> tuple[Verdict, str, list[Gate]]:
    """The verdict on the literal method: a fault where its oracle shows something else; where both differ from exact
    intersections, that is its nature."""
    asked, wrong = metrics["oracle pixels"], metrics["pixels unlike exact"]
    gates = [_gate("oracle mismatches", metrics["oracle mismatches"], 0, "pixels",
                   f"of {asked} pixels asked for, those on which the recursive tracer shows another object, distance or "
                   "colour"),
             _gate("oracle excused pixels", metrics["oracle excused pixels"], metrics["pixels at risk"], "pixels",
                   "pixels on which the two differ by no more than rounding may change; no more than rounding changes")]
    if broken := [gate for gate in gates if not gate.holds]:
        return "differs", (f"{broken[0].name}: {broken[0].value} of {asked} pixels, {broken[0].limit:g} allowed; they differ "
                           f"by up to {metrics['oracle color max']:.3g}"), gates
    if not wrong:
        return "agrees", (f"at step size {step_size:g} the literal method shows what exact intersections show; its oracle "
                          f"agrees on all {asked} pixels asked for"), gates
    reasons = sorted(((count, name.removeprefix("cause: ")) for name, count in metrics.items() if name.startswith("cause: ")),
                     reverse=True)
    told = ", ".join(f"{count} {name}" for count, name in reasons)
    return "expected", (f"{wrong} pixels differ from exact intersections; of {metrics['pixels unlike exact, asked']} of them "
                        f"the oracle shows the same at step size {step_size:g}: {told}"), gates


def judge(metrics: Metrics, tolerance: Tolerance, exact: Tolerance) -> tuple[Verdict, str, list[Gate]]:
    """The verdict on one comparison, the reason in one sentence, and the gates behind it.

    All pixels are held to their own limits; most of them to `tolerance`, and most of those whose rays meet exact shapes
    alone to `exact`.
    """
    at_risk = metrics.get("pixels at risk")
    kinds = ", ".join(f"{count} in {name.removeprefix('differing in ')}" for name, count in metrics.items()
                      if name.startswith("differing in "))
    gates = [
        _gate("not finite", metrics["not finite"], 0, "pixels", "pixels whose colour is NaN or infinite on either side"),
        _gate("differing pixels", metrics.get("differing pixels"), 0, "pixels",
              "pixels farther off than rounding and the errors of the surfaces on their paths explain, in object, distance, "
              "position, normal, generation or colour"),
        _gate("excused pixels", metrics.get("excused pixels"), at_risk, "pixels",
              "pixels that show what lies on the other side of an edge beside them; no more than the reference itself has at "
              "the mercy of rounding and of such errors"),
        _gate("unforeseen pixels", metrics.get("unforeseen pixels"), (at_risk or 0) // (PROBES + 1), "pixels",
              f"pixels beside edges that show what none of {PROBES} perturbed pictures shows there: one more does so with "
              f"probability 1 / {PROBES + 1}"),
        _gate("undecided pixels", metrics.get("undecided pixels"), at_risk, "pixels",
              "pixels that the reference itself leaves open: they judge nobody; no more than rounding explains"),
        _gate("depth p99", metrics["depth p99"], tolerance.depth_p99, "relative",
              "99 % of interior pixels have a smaller relative error of depth", none=not metrics["interior hit pixels"]),
        _gate("color p99", metrics["color p99"], tolerance.color_p99, "linear",
              "99 % of all pixels have a smaller error of colour"),
    ]
    if metrics.get("displaced pixels"):
        gates += [_gate("depth p99, exact shapes", metrics["depth p99, exact shapes"], exact.depth_p99, "relative",
                        "the same of pixels whose rays meet no mesh or grid", none=not metrics["exact hit pixels"]),
                  _gate("color p99, exact shapes", metrics["color p99, exact shapes"], exact.color_p99, "linear",
                        "the same of pixels whose rays meet no mesh or grid", none=not metrics["exact pixels"])]
    broken = [gate for gate in gates if not gate.holds]
    if broken:
        worst = broken[0]
        others = {0: "", 1: "; one more limit is exceeded"}.get(
            len(broken) - 1, f"; {len(broken) - 1} more limits are exceeded")
        how = f" ({kinds})" if worst.name == "differing pixels" and kinds else ""
        return "differs", f"{worst.name} is {_shown(worst.value)}{how}, {_shown(worst.limit)} is allowed{others}", gates
    return "agrees", f"every limit for {tolerance.name} holds ({tolerance.because})", gates


def _gate(name: str, value, limit: float | None, unit: str, means: str, none: bool = False) -> Gate:
    # NaN breaks every gate, and so does None, unless there was nothing to be measured: then `none` is true
    limit = 0 if limit is None else limit
    return Gate(name=name, value=value, limit=limit, holds=none if value is None else bool(value <= limit), unit=unit,
                means=means)


def _shown(value) -> str:
    if value is None:
        return "nothing"
    return f"{int(value)}" if abs(value) < 1e15 and value == int(value) else f"{value:.3g}"  # NaN is below nothing
