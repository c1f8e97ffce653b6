"""Every limit that decides a verdict: its value, its unit, and where it comes from.

A derived limit follows from a formula; a measured one is what a command shows, with room to the next worse setting, which
the same command holds against it (its rows "tight" and "loose").
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import astuple, dataclass
from typing import Literal

from raytruth.reference_tracer.tracer.sensitivity import DIRECTION_UNITS, FLOOR_UNITS, ORIGIN_UNITS, PROBES, SAFETY

from ..results import Run, Verdict
from .conditioning import Accuracy

MEASURED = "raytruth compare"
PREDICTED = "raytruth sensitivity figure-17-scene1 --verify 8"


@dataclass(frozen=True)
class Limit:
    name: str
    value: float
    unit: str
    origin: Literal["derived", "measured", "assumed"]
    by: str  # the formula, or the command that measures it, or that holds what is assumed against a new picture


@dataclass(frozen=True)
class Tolerance:
    """How far most pixels of a kind of renderer may be from the truth, and why so far; single pixels have limits of their
    own (conditioning.py)."""

    name: str
    because: str
    depth_p99: float  # relative
    color_p99: float


NATIVE = Tolerance("native shapes", "single precision, and ray origins offset by a unit of it", depth_p99=5e-7, color_p99=2e-6)
# colours: midway, by ratio, between the 1.44e-3 of figure 17 and the 6.5e-3 that it has with meshes of half the resolution
# (raytruth compare --largest 320: its rows of what is tight)
MESH = Tolerance("meshes", "surfaces replaced by triangles, error falling with the square of the resolution",
                 depth_p99=1e-4, color_p99=3e-3)
GRID = Tolerance("grids", "f replaced by its trilinear interpolation, error falling with the square of the cells",
                 depth_p99=3e-4, color_p99=1e-2)
TRACERS = Tolerance("two tracers of one mesh", "the triangles are the same; what is left is single precision",
                    depth_p99=5e-7, color_p99=3e-5)
ORACLE = Tolerance("POV-Ray", "double precision, colours of 16 bits", depth_p99=1e-10, color_p99=2e-5)
DOUBLE = Tolerance("double precision", "the same model in double precision", depth_p99=1e-9, color_p99=1e-9)
# marked as loose: what POV-Ray's worse settings change shows in single pixels, and each has a limit of its own
LOOSE = (ORACLE.name,)

# of an oracle's every pixel, with primitives: a step of 16 bits, 2^-16 = 1.5e-5, and the rounding of what is added to it;
# with isosurfaces at accuracy 1e-8 what their normals, differences over that distance, are off by
ANALYTICAL, NUMERICAL = 2e-5, 2e-4
STEPS_OF_NORMALS, NUMERICAL_NORMALS = 2.0**-14, 1e-3  # of three channels of 16 bits each, 2 / 2^16 wide; of isosurfaces
REPEATED = 1e-9  # of every plane of a pixel that two programs compute in double precision by the same method


def tolerance_of(run: Run, exact: bool = False) -> Tolerance:
    """How far most pixels of a run may be from the truth; with `exact`, those whose rays meet no mesh or grid.

    Where a renderer has no exact shape for a surface, triangles stand for it.
    """
    if run.renderer in ("exact", "paper"):
        return DOUBLE
    if run.renderer.startswith("povray"):
        return ORACLE
    if run.facts.get("grids") and not exact:
        return GRID
    if not run.facts.get("triangles") and run.facts.get("precision") == 64:
        return DOUBLE
    # hits on triangles may have been moved onto the surface they stand for
    return MESH if run.facts.get("triangles") and not run.facts.get("refined") and not exact else NATIVE


def accuracy_of(run: Run) -> Accuracy | None:
    """What single pixels of a run are held to; None where its errors are not measurable, and of the reference, the truth."""
    if (run.settings.get("method") and run.facts.get("precision", 64) == 64) or not measurable(run):
        return None
    exact = {}
    if tolerance_of(run) is ORACLE:
        numerical = bool(run.facts.get("isosurfaces"))
        # colours are in units of the brightest possible one: 16 bits tell no more of it
        exact = {"color": (NUMERICAL if numerical else ANALYTICAL) * max(1.0, run.facts.get("brightest") or 1.0),
                 "t": ORACLE.depth_p99, "normal": NUMERICAL_NORMALS if numerical else STEPS_OF_NORMALS}
    return Accuracy(int(run.facts.get("precision") or 32), tuple(run.errors), tuple(run.tilts), tuple(run.normal_errors),
                    **exact)


def between(first: Run, second: Run, exact: bool = False) -> Tolerance:
    """How far two runs may be from each other: each may be as far from the truth as its own tolerance says.

    `exact` asks for pixels whose rays meet no mesh or grid."""
    a, b = tolerance_of(first, exact), tolerance_of(second, exact)
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


def measurable(run: Run) -> bool:
    """Whether it is known how far the surfaces of a run, and their normals, are off."""
    return None not in (*run.errors, *run.normal_errors, run.facts.get("measured_mesh_error", 0))


def unmeasured(run: Run) -> str:
    """Why a picture that keeps every limit proves nothing; "" where it does."""
    return "" if measurable(run) else "every limit holds, but how far its meshes are from the surfaces is not measurable"


def unproven(run: Run) -> str:
    """Why what differs in a run's picture may not be its renderer's fault; "" where it is: its scene may be another one."""
    what = run.facts.get("not proven")
    return f"its scene is not proven to be the same: {what}" if what else ""


def concluded(verdict: Verdict, reason: str, *runs: Run) -> tuple[Verdict, str]:
    """What a verdict on the `runs` tells, and why: nothing, where what it would follow from is not known of one of them."""
    if verdict == "agrees" and (why := next(filter(None, map(unmeasured, runs)), "")):
        return "not compared", why
    if verdict == "differs" and (why := next(filter(None, map(unproven, runs)), "")):
        return "not compared", f"{reason}, which tells nothing: {why}"
    return verdict, reason


def table() -> Iterator[Limit]:
    """All limits."""
    units = {"depth_p99": "relative", "color_p99": "linear"}
    for tolerance in (NATIVE, MESH, GRID, TRACERS, ORACLE, DOUBLE):
        for name, unit in units.items():
            yield Limit(f"{tolerance.name}: {name}", getattr(tolerance, name), unit, "measured",
                        f"{MEASURED} --renderers mitsuba-sdfgrid" if tolerance is GRID else MEASURED)
    yield Limit("POV-Ray: colour, primitives", ANALYTICAL, "of the brightest colour", "derived", "2^-16 and its rounding")
    yield Limit("POV-Ray: normals, primitives", STEPS_OF_NORMALS, "length", "derived",
                "sqrt(3) 2 / 2^16, rounded up to 4 / 2^16")
    for what, value in (("colour", NUMERICAL), ("normals", NUMERICAL_NORMALS)):
        yield Limit(f"POV-Ray: {what}, isosurfaces", value, "of the brightest colour" if what == "colour" else "length",
                    "measured", "raytruth compare --renderers povray-isosurface")
    yield Limit("every pixel: perturbations", PROBES, "pictures", "derived", "an edge escapes n of them with probability 2^-n")
    yield Limit("every pixel: times the largest answer", SAFETY, "factor", "derived",
                "all n samples stay below 1 / s of the largest possible one with probability s^-n, 2e-6 of 12")
    yield Limit("every pixel: rays' origins", ORIGIN_UNITS, "units of rounding", "assumed", PREDICTED)
    yield Limit("every pixel: rays' directions", DIRECTION_UNITS, "units of rounding", "assumed", PREDICTED)
    yield Limit("every pixel: shading", FLOOR_UNITS, "units of rounding", "assumed", PREDICTED)
    yield Limit("literal method: every plane", REPEATED, "relative", "measured",
                "raytruth compare --renderers paper")
