"""Section 4.3: what happens where a ray meets an object, for a whole wave of rays at once."""

from __future__ import annotations

from dataclasses import dataclass

import drjit as dr

from .rays import Hit, Ray, Sides
from .world import Material, World

ROUNDING_OF_LENGTHS = 16  # units of rounding in the square of a normalised vector's length: seven operations, and spare


@dataclass
class Interaction:
    """One ray's answer: its own colour, and the secondary rays with the weight each has in it.

    A weight is None where no object of the scene makes such rays.
    """

    hit: Hit
    point: object  # Vector, where the ray met the object
    normal: object  # Vector, unit, turned against the ray (decision N1)
    color: object  # Vector, visibleColor (1 - reflection) (1 - transparency), or the background
    smooth: object  # Bool, the gradient exists there, and the normal has length 1
    lights_asked: object  # UInt, shadow rays traced
    lights_reached: object  # UInt, how many of them reached their light
    lights_undecided: object  # UInt, how many of them are undecided
    reflected: object | None  # Vector, direction
    reflected_weight: object | None  # Float
    refracted: object | None  # Vector, direction
    refracted_weight: object | None  # Float
    refracted_sides: Sides | None
    total_reflection: object | None  # Bool

    @property
    def undecided(self):
        """Whether the method cannot vouch for this ray, or for one of its shadow rays (Bool)."""
        return self.hit.undecided | ~self.smooth | (self.lights_undecided > 0)


def interact(world: World, ray: Ray, active) -> Interaction:
    """Traces `ray` to its first hit and shades it (sections 4.1 to 4.3.4).

    pointColor = (visibleColor (1 - R) + R reflectionColor) (1 - T) + T refractionColor, written as a sum with the
    weights (1 - R)(1 - T), R (1 - T) and T, so that a wave needs no recursion.
    """
    Float = world.arrays.Float
    hit = world.nearest(ray)
    met = active & (hit.index < world.object_count)
    t = dr.select(met, hit.t, 0)
    point = dr.fma(ray.d, t, ray.o)
    gradient = world.normal(point, hit.index, met)
    normal, cos1 = world.optics.facing(ray.d, gradient)
    # where the gradient does not exist (O4, O5), overflows or underflows there is no normal: face the ray, and say that
    # the pixel is undecided
    smooth = ~met | (dr.abs(dr.squared_norm(normal) - 1) < ROUNDING_OF_LENGTHS * dr.epsilon(Float))
    normal, cos1 = dr.select(smooth, normal, -ray.d), dr.select(smooth, dr.minimum(cos1, 1), 1)

    material = world.material(hit.index, met)
    R = material.reflection if world.reflective else 0.0
    T = material.transparency if world.transparent else 0.0
    local_weight = dr.select(met, world.optics.own_weight(R, T), 0)
    illumination, asked, reached, unsure = _illumination(world, ray, point, normal, met & (local_weight > 0))
    background = world.arrays.Vector(*world.background)
    color = dr.select(met, material.color * illumination * local_weight, dr.select(active, background, 0))

    hit.undecided &= active
    interaction = Interaction(hit, point, normal, color, smooth, asked, reached, unsure, *[None] * 6)
    if world.reflective or world.transparent:
        interaction.reflected = dr.normalize(world.optics.reflect(ray.d, normal, cos1))  # renormalised at every bounce (R4)
        interaction.reflected_weight = dr.select(met, Float(R * (1.0 - T)), 0)
        if not world.traces["reflection"]:
            interaction.color += background * interaction.reflected_weight
            interaction.reflected_weight = Float(0)
    if world.transparent:
        if world.traces["refraction"]:
            _add_refraction(world, ray, interaction, material, cos1, met)
        else:
            interaction.color += background * dr.select(met, T, 0)
    return interaction


@dr.syntax
def _illumination(world: World, ray: Ray, point, normal, active):
    """Section 4.3.1: the sum over lights of max(cos(phi), 0) * brightness * intensity (decisions L1 to L3, F1, F2).

    Returns (Vector, UInt shadow rays traced, UInt those that reached their light, UInt undecided ones).
    """
    UInt = world.arrays.UInt
    total, balanced = world.arrays.Vector(*[world.ambient] * 3), world.scene.tracing.lights == "balanced"
    asked, reached, undecided, j = UInt(0), UInt(0), UInt(0), UInt(0)
    while j < world.light_count:
        position, brightness = world.light(j)
        to_light = position - point
        distance = dr.norm(to_light)
        shadow_dir = to_light / distance
        cos = dr.dot(shadow_dir, normal)
        faces = active & (cos > 0)
        # the shadow ray starts on the side the ray came from, like the reflection ray (M3)
        intensity, unsure = world.transmittance(Ray(point, shadow_dir, ray.sides), distance, faces)
        total = world.optics.combined(total, brightness * world.optics.light(cos, intensity, distance), balanced)
        asked += dr.select(faces, UInt(1), 0)
        reached += dr.select(faces & (intensity > 0), UInt(1), 0)
        undecided += dr.select(unsure, UInt(1), 0)
        j += 1
    return total, asked, reached, undecided


def _add_refraction(world: World, ray: Ray, interaction: Interaction, material: Material, cos1, met):
    """Section 4.3.3, pairwise with air: which medium the ray comes from follows from its side (decision R1)."""
    T, n = material.transparency, material.refractive_index
    leaving = ray.sides.test(interaction.hit.index)
    n1, n2 = dr.select(leaving, n, 1), dr.select(leaving, 1, n)
    as_printed = world.scene.tracing.refraction == "as_printed"
    refraction = world.optics.refract(ray.d, interaction.normal, cos1, n1, n2, as_printed)
    # total internal reflection keeps the weight T; the direction it shares with the reflection is traced once (R3)
    interaction.total_reflection = met & refraction.total
    interaction.reflected_weight += dr.select(interaction.total_reflection, T, 0)
    interaction.refracted_weight = dr.select(met & ~refraction.total, T, 0)
    interaction.refracted = dr.normalize(refraction.direction)
    interaction.refracted_sides = ray.sides.flipped(dr.select(met, interaction.hit.index, 0))
