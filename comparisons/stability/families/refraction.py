"""Families of the law of refraction: critical angles, normal incidence, the misprinted formula, a stack of slabs.

All surfaces are planes with the normal (1, 2, 2)/3, across no axis, so that no digit is exact by chance.
"""

from __future__ import annotations

import math
from dataclasses import replace

import drjit as dr
import numpy as np

from reference_tracer.tracer.rays import Ray
from reference_tracer.scene.model import Scene
from reference_tracer.tracer.shading import interact

from ..exact import rational
from ..family import About
from ..law import Law
from ..methods import METHODS, Method
from ..outcome import CODE
from ..rays import Draw
from ..scenes import Case, ModelFamily, Observed, camera_rays, judged, plane, scene, world_of

NORMAL = np.array([1.0, 2.0, 2.0]) / 3
ACROSS = np.array([[2.0, 1.0, -2.0], [2.0, -2.0, 1.0]]) / 3  # an orthonormal frame together with NORMAL
GLASS, THIN = 1.5, 0.8
SLABS, THICKNESS, GAP = 4, 0.1, 0.1
PRINTED = replace(METHODS[0], name="refraction as printed", title="sin(phi2) = sin(phi1) n2/n1, as printed",
                  wrong_variant="a misprint (decision E1): it contradicts the law of refraction stated above it")


def _half_space(index: float, camera) -> Scene:
    return scene(plane((1, 2, 2), (0, 0, 0), transparency=1.0, refractive_index=index), camera=camera)


def _towards_plane(draw: Draw, sine, sign: float):
    """(o, d) of rays that meet the plane at an angle of this sine to its normal, going along sign * NORMAL."""
    turn = draw.uniform(0, 2 * math.pi)
    along = np.column_stack([np.cos(turn), np.sin(turn)]) @ ACROSS
    sine = np.reshape(sine, (-1, 1))
    d = sine * along + sign * np.sqrt((1 - sine) * (1 + sine)) * NORMAL
    return draw.stored(draw.uniform(-1, 1, (2,)) @ ACROSS - d), draw.stored(d)


# --- total reflection ------------------------------------------------------------------------------------------------
def _near_critical(p: float, draw: Draw, n1: float, n2: float) -> Case:
    """Sines (1 +- p u) n2/n1, u uniform in [1/2, 1]; which of them exceed n2/n1 is decided by rational arithmetic."""
    sine = n2 / n1 * (1 + p * draw.random.choice([-1.0, 1.0], draw.count) * draw.uniform(0.5, 1))
    leaving = n1 > 1
    o, d = _towards_plane(draw, sine, sign=1.0 if leaving else -1.0)
    index = float(draw.stored(n1 if leaving else n2))
    limit = (1 / rational(index) if leaving else rational(index)) ** 2
    total = np.array([_sine_squared(v) > limit for v in d])
    return Case(_half_space(index, -NORMAL if leaving else NORMAL), o, d, {"total": total})


def _sine_squared(d):
    """Of the angle between d and (1, 2, 2), exactly."""
    x, y, z = map(rational, d)
    along = x + 2 * y + 2 * z
    return 1 - along * along / (9 * (x * x + y * y + z * z))


def _observe_total(case: Case, method: Method, precision: int) -> Observed | None:
    world = world_of(case.scene, method, precision)
    if world is None:
        return None
    interaction = interact(world, camera_rays(world, case.o, case.d), world.arrays.Bool(True))
    dr.eval(interaction)
    total, truth = interaction.refracted_weight.numpy() == 0, case.truth["total"]
    met = interaction.hit.index.numpy() < world.object_count
    kinds = np.full(len(total), CODE["correct"])
    for name, where in (("false", total & ~truth), ("missed", ~total & truth), ("missed", ~met),
                        ("undecided", interaction.undecided.numpy())):
        kinds[np.broadcast_to(where, kinds.shape)] = CODE[name]
    return Observed(kinds, np.full(len(kinds), np.nan))


# --- directions ------------------------------------------------------------------------------------------------------
def _snell(d, n1: float, n2: float) -> np.ndarray:
    """Snell's law in components: the part of d along the surface is multiplied by n1/n2, the rest follows."""
    d = d / np.linalg.norm(d, axis=1, keepdims=True)
    along = (d @ ACROSS.T) * (n1 / n2)
    return along @ ACROSS + (np.sign(d @ NORMAL) * np.sqrt(1 - np.sum(along**2, axis=1)))[:, None] * NORMAL


def _entering(sine, draw: Draw) -> Case:
    o, d = _towards_plane(draw, np.full(draw.count, sine), sign=-1.0)
    return Case(_half_space(GLASS, NORMAL), o, d, {"direction": _snell(d, 1.0, GLASS)})


def _observe_direction(case: Case, method: Method, precision: int) -> Observed | None:
    traced = case.scene.traced_with(refraction="as_printed") if method.name == PRINTED.name else case.scene
    world = world_of(traced, method, precision)
    if world is None:
        return None
    ray = camera_rays(world, case.o, case.d)
    met, undecided = True, False
    for _ in range(len(case.scene.objects)):
        interaction = interact(world, ray, world.arrays.Bool(True))
        dr.eval(interaction)
        met = met & (interaction.hit.index.numpy() < world.object_count)
        undecided = undecided | (interaction.hit.undecided.numpy() | ~interaction.smooth.numpy())
        ray = Ray(interaction.point, interaction.refracted, interaction.refracted_sides)
    error = np.abs(ray.d.numpy().T - case.truth["direction"]).max(axis=1)
    if "point" in case.truth:
        error = np.maximum(error, np.abs(ray.o.numpy().T - case.truth["point"]).max(axis=1))
    return judged(error, 1e-9 if precision == 64 else 1e-4, met=met, undecided=undecided)


def _slab_stack(p: float, draw: Draw) -> Case:
    """Slabs as pairs of half-spaces: a ray enters each upper one, and leaves each lower one, which holds the camera.

    Entry and exit direction agree; each slab shifts the ray by its thickness times tan(phi2), each gap by tan(phi1).
    """
    tops = [-k * (THICKNESS + GAP) for k in range(SLABS)]
    glass = {"transparency": 1.0, "refractive_index": GLASS}
    objects = [face for top in tops for face in (plane((1, 2, 2), top * NORMAL, **glass),
                                                 plane((-1, -2, -2), (top - THICKNESS) * NORMAL, **glass))]
    sine = math.cos(p)
    _, d = _towards_plane(draw, np.full(draw.count, sine), sign=-1.0)
    height = draw.uniform(0.05, 0.1)
    o = draw.uniform(-1, 1, (2,)) @ ACROSS + height[:, None] * NORMAL
    inner = math.tan(math.asin(sine / GLASS))
    shift = (height + (SLABS - 1) * GAP) / math.tan(p) + SLABS * THICKNESS * inner
    along = (d @ ACROSS.T) / sine @ ACROSS
    depth = height + SLABS * THICKNESS + (SLABS - 1) * GAP
    point = o + shift[:, None] * along - depth[:, None] * NORMAL
    return Case(scene(*objects, camera=NORMAL), o, d, {"direction": d, "point": point})


FAMILIES = (
    ModelFamily(
        About("critical-angle", "Leaving glass at the critical angle", "relative distance of the sine from n2/n1 = 2/3",
              (1e-2, 1e-6, 1e-10, 1e-12, 1e-14, 1e-15, 1e-16),
              when="The sine of the angle agrees with the critical one to almost all digits.",
              why="sin = sqrt(1 - cos^2) carries a rounding error of 1e-16 (fp64) or 1e-7 (fp32); on one side of it a "
                  "ray turns back, on the other it goes on.",
              instead="Nothing: such pixels are ill-conditioned; a comparison has to excuse them.",
              single=(1e-2, 1e-4, 1e-5, 1e-6, 1e-7), answerable=False),
        lambda p, draw: _near_critical(p, draw, GLASS, 1.0), _observe_total,
        laws=tuple(Law(m.name, "0 down to p = 1e-14", lambda p: 0.0 if p >= 1e-14 else None) for m in METHODS)),
    ModelFamily(
        About("thin-medium", "Entering a medium with n < 1", "relative distance of the sine from n = 0.8",
              (1e-2, 1e-6, 1e-10, 1e-12, 1e-14, 1e-15, 1e-16),
              when="Light comes from outside at an angle above asin(n): it is totally reflected on entry.",
              why="A tracer that expects total reflection only inside of objects takes the root of a negative number.",
              instead="Decide by n1 and n2 of the side the ray is on, whichever is larger.",
              single=(1e-2, 1e-4, 1e-5, 1e-6, 1e-7), answerable=False),
        lambda p, draw: _near_critical(p, draw, 1.0, THIN), _observe_total,
        laws=tuple(Law(m.name, "0 down to p = 1e-14", lambda p: 0.0 if p >= 1e-14 else None) for m in METHODS)),
    ModelFamily(
        About("normal-incidence", "Straight into glass", "angle of incidence, radians",
              (1e-1, 1e-2, 1e-4, 1e-8, 1e-12, 0.0),
              when="A ray runs along the normal.",
              why="cos(phi1) may round to more than 1; sqrt(1 - cos^2) is then not a number unless it is held at 0.",
              instead="Clamp: the direction is then exact to rounding, and unchanged at p = 0.",
              single=(1e-1, 1e-2, 1e-4, 1e-8, 0.0)),
        lambda p, draw: _entering(math.sin(p), draw), _observe_direction,
        laws=(Law("paper", "0", lambda p: 0.0),)),
    ModelFamily(
        About("printed-refraction", "The printed formula for refraction", "angle of incidence, degrees",
              (0.1, 5.0, 20.0, 30.0, 40.0, 41.5, 42.0, 60.0, 80.0),
              when="sin(phi2) = sin(phi1) n2/n1 is used as printed in section 4.3.3.2.",
              why="It contradicts the law of refraction; on entry into n = 1.5 the sine exceeds 1 from 41.8 degrees.",
              instead="sin(phi2) = sin(phi1) n1/n2 (decision E1)."),
        lambda p, draw: _entering(math.sin(math.radians(p)), draw), _observe_direction, variants=(PRINTED,),
        laws=(Law("paper", "0", lambda p: 0.0),
              Law(PRINTED.name, "1: every direction is wrong", lambda p: 1.0),
              Law(PRINTED.name, "not a number from asin(1/1.5) = 41.8 degrees on",
                  lambda p: float(math.sin(math.radians(p)) * GLASS > 1), kinds=("non-finite",)))),
    ModelFamily(
        About("slab-stack", "Through a stack of glass slabs", "angle between the ray and the slabs, radians",
              (1.2, 0.5, 0.2, 0.1, 0.05, 0.02),
              when="A ray passes eight faces at a grazing angle.",
              why="Errors of direction grow by 1/sin(p) at every exit; the side of every object has to be inherited.",
              instead="Inherited sides (decision M3) and directions normalised at every bounce (R4)."),
        _slab_stack, _observe_direction,
        laws=(Law("paper", "0: parallel faces leave the direction as it was", lambda p: 0.0),)))
