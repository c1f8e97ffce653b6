"""Faults made on purpose: one passage of the reference tracer replaced, for the length of one picture.

What notices differences has to be shown differences. Each fault is a slip that a port of the document may make, the
scene on which it shows, and the stage that must be named for it.
"""

from __future__ import annotations

import importlib
import importlib.util
import inspect
import sys
import tempfile
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from types import FunctionType
from unittest.mock import patch

from reference_tracer.errors import InputError

from .records import Stage


@dataclass(frozen=True)
class Fault:
    """`right` stands once in the module's source; `effect` is the scene of one effect on which `wrong` shows."""

    id: str
    title: str
    module: str
    right: str
    wrong: str
    effect: str
    stage: Stage
    because: str


FAULTS = {f.id: f for f in (
    Fault("y-flipped", "rows counted from the bottom", "reference_tracer.tracer.camera",
          "f.ratio * (-(row + (sample_row + 0.5) / samples) + f.height * 0.5)",
          "f.ratio * ((row + (sample_row + 0.5) / samples) - f.height * 0.5)", "effect-shading", "camera",
          "every ray goes through another pixel's place (section 2, decision C1)"),
    Fault("rays-end-early", "rays that end at a fifth of max_distance", "reference_tracer.tracer.world",
          "dr.select(usable, self.max_distance, 0)", "dr.select(usable, 0.2 * self.max_distance, 0)", "effect-shadow", "hit",
          "what lies beyond is not hit (section 4.1, decision M5)"),
    Fault("one-decimal", "roots found to one decimal", "reference_tracer.tracer.world",
          "dr.select(closer, c.t, t)", "dr.select(closer, dr.round(c.t * 10) / 10, t)", "effect-shading", "root",
          "the right object is hit at the wrong distance: the iteration of section 4.2 ends too early"),
    Fault("normal-not-turned", "normals not turned against the ray", "reference_tracer.tracer.shading",
          "normal = dr.select(cos1 < 0, -gradient, gradient)", "normal = gradient", "effect-refraction", "normal",
          "from within an object the gradient points along the ray (decision N1)"),
    Fault("falling-off", "light that falls off with the distance", "reference_tracer.tracer.shading",
          "cos * intensity, 0)", "cos * intensity * 9 / (distance * distance), 0)", "effect-shading", "shading",
          "illumination = cos(phi) brightness intensity knows no distance (section 4.3.1, decision L1)"),
    Fault("shadow-once", "transparency T instead of T² in shadows", "reference_tracer.tracer.world",
          "_multiply_repeatedly(intensity, transparency, count)",
          "dr.select(count > 0, intensity * transparency, intensity)", "effect-shadow", "shadow",
          "light is weakened at every crossing, so twice by a solid in its way (decision L3)"),
    Fault("reflected-short", "reflection direction without its factor 2", "reference_tracer.tracer.shading",
          "d + normal * (2 * cos1)", "d + normal * cos1", "effect-reflection", "reflection",
          "the ray leaves along the surface (section 4.3.2)"),
    Fault("as-printed", "the law of refraction as printed (E1)", "reference_tracer.tracer.shading",
          "n2 / n1 if as_printed else n1 / n2", "n2 / n1", "effect-refraction", "refraction",
          "the sine of the second angle is multiplied by n2/n1 instead of n1/n2 (section 4.3.3.2, decision E1)"),
    Fault("no-total-reflection", "total reflection left out", "reference_tracer.tracer.shading",
          "total = sin1 > n2 / n1\n", "total = sin1 > 1e9 * n2 / n1\n", "effect-total-reflection", "refraction",
          "beyond the critical angle a ray leaves along the surface instead of bouncing (section 4.3.3.1)"),
    Fault("no-1-minus-r", "visible colour without its factor 1 − reflection", "reference_tracer.tracer.shading",
          "(1.0 - R) * (1.0 - T), 0)", "(1.0 - T), 0)", "effect-mixing", "mixing",
          "1 − reflection weighs the point's own colour in the sum of section 4.3.4: no ray is wrong, their sum is"),
    Fault("mean-of-n", "n × n samples divided by n", "reference_tracer.tracer.film",
          "samples**2 / color_unit", "samples / color_unit", "effect-multisampling", "sampling",
          "one sample a pixel is right, the mean of n × n is not (section 5)"),
)}


def fault(id: str) -> Fault:
    """The fault called `id`. Raises InputError."""
    if id not in FAULTS:
        raise InputError(f"unknown fault {id!r}; choose one of {', '.join(FAULTS)}")
    return FAULTS[id]


@contextmanager
def in_place(f: Fault):
    """The tracer with the fault, until the context ends. Raises InputError where the passage is gone."""
    original, wrong = importlib.import_module(f.module), _mutant(f)
    with ExitStack() as stack:
        for key, value in list(vars(original).items()):
            if getattr(value, "__module__", None) != f.module:
                continue
            if inspect.isclass(value):
                for attribute, member in vars(getattr(wrong, key)).items():
                    if isinstance(member, (FunctionType, staticmethod, classmethod, property)):
                        stack.enter_context(patch.object(value, attribute, member))
            else:  # wherever it has been imported
                for user, module in list(sys.modules.items()):
                    if user.startswith("reference_tracer") and vars(module).get(key) is value:
                        stack.enter_context(patch.object(module, key, getattr(wrong, key)))
        yield


@cache
def _mutant(f: Fault):
    """The fault's module with its passage replaced."""
    path = Path(importlib.import_module(f.module).__file__)
    source = path.read_text(encoding="utf-8")
    if source.count(f.right) != 1:
        raise InputError(f"fault {f.id}: its passage is not to be found in {f.module}: {f.right!r}")
    # a file, because Dr.Jit reads the source of its loops
    folder = Path(_folder().name)
    (folder / f"{f.id}.py").write_text(source.replace(f.right, f.wrong), encoding="utf-8")
    spec = importlib.util.spec_from_file_location(f.module, folder / f"{f.id}.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@cache
def _folder() -> tempfile.TemporaryDirectory:
    return tempfile.TemporaryDirectory(prefix="raytruth-wrong-")
