"""Families of mirrors facing each other: do errors grow from bounce to bounce, and what does a depth limit cost?"""

from __future__ import annotations

from functools import partial

import numpy as np

from reference_tracer.tracer.shading import Interaction
from reference_tracer.tracer.wavefront import Wave, trace

from ..family import About
from ..law import Law
from ..methods import METHODS, Method
from ..rays import Draw, unit
from ..scenes import Case, ModelFamily, Observed, camera_rays, judged, plane, scene, world_of

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


def _observe(case: Case, method: Method, precision: int, accuracy: float) -> Observed | None:
    """Holds the sum of the colours up to each ray's generation against its value."""
    world = world_of(case.scene, method, precision)
    if world is None:
        return None
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
        About("mirror-box", "A box of mirrors", "number of reflections",
              (1.0, 2.0, 4.0, 8.0, 16.0, 32.0, float(MOST_REFLECTIONS)),
              when="A ray is reflected many times.",
              why="Every bounce adds rounding; a crossing missed once, or a side lost once, spoils all that follows.",
              instead="Inherited sides: between plane mirrors errors then grow no faster than the path."),
        _mirror_box, partial(_observe, accuracy=ACCURACY),
        laws=(Law("paper", "0: planes have no step too small to see", lambda p: 0.0),)),
    ModelFamily(
        About("depth-limit", "What the depth limit cuts off", "reflection R of two facing mirrors, max_depth 2",
              (0.05, 0.12, 0.13, 0.14, 0.15, 0.2, 0.9), answerable=False,
              when="Bright surfaces reflect each other more often than max_depth allows.",
              why="R^(D + 1) of the light is missing; it is visible where that exceeds half an 8-bit level.",
              instead="A max_depth of log(1/512) / log(R) or more."),
        _facing_mirrors, partial(_observe, accuracy=VISIBLE),
        laws=tuple(Law(m.name, "share of pixels with R^3 c > 1/512, c uniform in [1/2, 1]", depth_rate)
                   for m in METHODS)))
