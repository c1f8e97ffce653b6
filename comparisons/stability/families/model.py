"""Families of the whole model: the law of refraction, and mirrors that face each other.

All refracting surfaces are planes with the normal (1, 2, 2)/3, across no axis, so that no digit is exact by chance.
"""

from __future__ import annotations

import math
from dataclasses import replace
from functools import partial

import drjit as dr
import numpy as np

from raytruth.reference_tracer.scene.model import Scene
from raytruth.reference_tracer.tracer.rays import Ray
from raytruth.reference_tracer.tracer.shading import Interaction, interact
from raytruth.reference_tracer.tracer.wavefront import Wave, trace
from raytruth.reference_tracer.tracer.world import World

from ..exact import rational
from ..family import About, Case, Draw, Law, ModelFamily, Observed, camera_rays, coded, judged, plane, scene, unit
from ..methods import METHODS

NORMAL = np.array([1.0, 2.0, 2.0]) / 3
ACROSS = np.array([[2.0, 1.0, -2.0], [2.0, -2.0, 1.0]]) / 3  # an orthonormal frame together with NORMAL
GLASS, THIN = 1.5, 0.8
SLABS, THICKNESS, GAP = 4, 0.1, 0.1
PRINTED = replace(METHODS[0], name="refraction as printed", title="sin(phi2) = sin(phi1) n2/n1, as printed",
                  wrong_variant="a misprint (decision E1): it contradicts the law of refraction stated above it")


CRITICAL_LAWS = tuple(Law(m.name, "0 down to p = 1e-14", lambda p: 0.0 if p >= 1e-14 else None) for m in METHODS)


def _half_space(index: float, camera) -> Scene:
    return scene(plane((1, 2, 2), (0, 0, 0), transparency=1.0, refractive_index=index), camera=camera)


def _towards_plane(draw: Draw, sine, sign: float):
    """(o, d) of rays that meet the plane at an angle of this sine to its normal, going along sign * NORMAL."""
    turn = draw.uniform(0, 2 * math.pi)
    along = np.column_stack([np.cos(turn), np.sin(turn)]) @ ACROSS
    sine = np.reshape(sine, (-1, 1))
    d = sine * along + sign * np.sqrt((1 - sine) * (1 + sine)) * NORMAL
    return draw.stored(draw.uniform(-1, 1, (2,)) @ ACROSS - d), draw.stored(d)


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


def _observe_total(case: Case, world: World) -> Observed:
    interaction = interact(world, camera_rays(world, case.o, case.d), world.arrays.Bool(True))
    dr.eval(interaction)
    total, truth = interaction.refracted_weight.numpy() == 0, case.truth["total"]
    met = interaction.hit.index.numpy() < world.object_count
    kinds = coded(len(truth), ("false", total & ~truth), ("missed", ~total & truth), ("missed", ~met),
                  ("undecided", interaction.undecided.numpy()))
    return Observed(kinds, np.full(len(kinds), np.nan))


def _snell(d, n1: float, n2: float) -> np.ndarray:
    """Snell's law in components: the part of d along the surface is multiplied by n1/n2, the rest follows."""
    d = d / np.linalg.norm(d, axis=1, keepdims=True)
    along = (d @ ACROSS.T) * (n1 / n2)
    return along @ ACROSS + (np.sign(d @ NORMAL) * np.sqrt(1 - np.sum(along**2, axis=1)))[:, None] * NORMAL


def _entering(sine, draw: Draw) -> Case:
    o, d = _towards_plane(draw, np.full(draw.count, sine), sign=-1.0)
    return Case(_half_space(GLASS, NORMAL), o, d, {"direction": _snell(d, 1.0, GLASS)})


def _observe_direction(case: Case, world: World) -> Observed:
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
    return judged(error, 1e-9 if world.arrays.precision == 64 else 1e-4, met=met, undecided=undecided)


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


# --- mirrors that face each other -------------------------------------------------------------------------------------
LIGHT = np.array([0.3, 0.4, -0.2])
REFLECTION = 0.9
MOST_REFLECTIONS = 64
DEPTH = 2  # of the family in which reflection varies
VISIBLE = 1 / 512  # half a level of an 8-bit picture
ACCURACY = 1e-9


def _mirror_box(reflections: float, draw: Draw) -> Case:
    """The cube [-1, 1]^3 from inside. Unfolded, the ray is straight: it meets the walls at odd coordinates.

    Folding those points back (a triangle wave) gives the walls and the cosines; the value is
    the sum of R^k (1 - R) cos_k up to the last reflection looked at.
    """
    walls = [plane(-sign * axis, sign * axis, reflection=REFLECTION) for axis in np.eye(3) for sign in (-1, 1)]
    room = scene(*walls, camera=(0, 0, 0), lights=[LIGHT], max_depth=MOST_REFLECTIONS)
    o, d = draw.uniform(-0.5, 0.5, (3,)), unit(draw.directions())
    bounces = int(reflections) + 1
    # the first odd number ahead along each axis, then every second one, or their mirror images
    first = (1 - np.sign(d) * o) / np.abs(d)
    each = first[:, :, None] + 2 * np.arange(bounces) / np.abs(d)[:, :, None]
    t = np.sort(each.reshape(draw.count, -1))[:, :bounces]
    unfolded = o[:, None, :] + t[:, :, None] * d[:, None, :]
    point = np.abs((unfolded - 1) % 4 - 2) - 1
    axis = np.argmax(np.abs(point), axis=2)
    wall = np.sign(np.take_along_axis(point, axis[:, :, None], 2)[:, :, 0])
    cosine = (1 - wall * LIGHT[axis]) / np.linalg.norm(LIGHT - point, axis=2)
    value = np.sum(REFLECTION ** np.arange(bounces) * (1 - REFLECTION) * cosine, axis=1)
    return Case(room, o, d, {"value": value, "generation": np.full(draw.count, bounces - 1)})


def _facing_mirrors(reflection: float, draw: Draw) -> Case:
    """Two mirrors at z = -1 and 1, rays straight to and fro, sqrt(1/c^2 - 1) beside a light in the middle.

    Every bounce sees the cosine c: without a limit the value is c (1 - R) (1 + R + R^2 + ...) = c. After D bounces
    R^(D + 1) c is missing.
    """
    mirrors = [plane((0, 0, -sign), (0, 0, sign), reflection=reflection) for sign in (-1, 1)]
    pair = scene(*mirrors, camera=(0, 0, 0), lights=[(0, 0, 0)], max_depth=DEPTH)
    cosine, turn = draw.uniform(0.5, 1), draw.uniform(0, 2 * np.pi)
    beside = np.sqrt(1 / cosine**2 - 1)
    o = np.column_stack([beside * np.cos(turn), beside * np.sin(turn), draw.uniform(-0.5, 0.5)])
    d = np.zeros_like(o)
    d[:, 2] = draw.random.choice([-1.0, 1.0], draw.count)
    return Case(pair, o, d, {"value": cosine, "generation": np.full(draw.count, DEPTH)})


def depth_rate(reflection: float) -> float:
    """P(R^(D + 1) c > 1/512) for c uniform in [1/2, 1]."""
    return min(1.0, max(0.0, (1 - VISIBLE / reflection ** (DEPTH + 1)) / 0.5))


def _observe_color(case: Case, world: World, accuracy: float) -> Observed:
    """Holds the sum of the colours up to each ray's generation against its value."""
    arrays, count = world.arrays, len(case.o)
    value, undecided, met = np.zeros(count), np.zeros(count, bool), np.ones(count, bool)

    def add(wave: Wave, interaction: Interaction):
        slot = wave.slot.numpy()
        counts = (wave.weight.numpy() > 0) & (case.truth["generation"][slot] >= wave.generation)
        value[slot[counts]] += (interaction.color.numpy()[0] * wave.weight.numpy())[counts]
        undecided[slot[counts]] |= interaction.undecided.numpy()[counts]
        met[slot[counts]] &= (interaction.hit.index.numpy() < world.object_count)[counts]

    wave = Wave(0, camera_rays(world, case.o, case.d), arrays.Float(np.ones(count)), arrays.UInt(np.arange(count)))
    trace(world, wave, slots=count, observe=add)
    return judged(np.abs(value - case.truth["value"]), accuracy, met=met, undecided=undecided)


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
        laws=CRITICAL_LAWS),
    ModelFamily(
        About("thin-medium", "Entering a medium with n < 1", "relative distance of the sine from n = 0.8",
              (1e-2, 1e-6, 1e-10, 1e-12, 1e-14, 1e-15, 1e-16),
              when="Light comes from outside at an angle above asin(n): it is totally reflected on entry.",
              why="A tracer that expects total reflection only inside of objects takes the root of a negative number.",
              instead="Decide by n1 and n2 of the side the ray is on, whichever is larger.",
              single=(1e-2, 1e-4, 1e-5, 1e-6, 1e-7), answerable=False),
        lambda p, draw: _near_critical(p, draw, 1.0, THIN), _observe_total,
        laws=CRITICAL_LAWS),
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
        traced=lambda scene, method: scene.traced_with(refraction="as_printed") if method is PRINTED else scene,
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
        laws=(Law("paper", "0: parallel faces leave the direction as it was", lambda p: 0.0),)),
    ModelFamily(
        About("mirror-box", "A box of mirrors", "number of reflections",
              (1.0, 2.0, 4.0, 8.0, 16.0, 32.0, float(MOST_REFLECTIONS)),
              when="A ray is reflected many times.",
              why="Every bounce adds rounding; a crossing missed once, or a side lost once, spoils all that follows.",
              instead="Inherited sides: between plane mirrors errors then grow no faster than the path."),
        _mirror_box, partial(_observe_color, accuracy=ACCURACY),
        laws=(Law("paper", "0: planes have no step too small to see", lambda p: 0.0),)),
    ModelFamily(
        About("depth-limit", "What the depth limit cuts off", "reflection R of two facing mirrors, max_depth 2",
              (0.05, 0.12, 0.13, 0.14, 0.15, 0.2, 0.9), answerable=False,
              when="Bright surfaces reflect each other more often than max_depth allows.",
              why="R^(D + 1) of the light is missing; it is visible where that exceeds half an 8-bit level.",
              instead="A max_depth of log(1/512) / log(R) or more."),
        _facing_mirrors, partial(_observe_color, accuracy=VISIBLE),
        laws=tuple(Law(m.name, "share of pixels with R^3 c > 1/512, c uniform in [1/2, 1]", depth_rate)
                   for m in METHODS)))
