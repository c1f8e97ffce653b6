"""The shadow rays of a wave once more, each with the verdicts of two methods."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import drjit as dr

from ..tracer.rays import Ray
from ..tracer.shading import Interaction
from ..tracer.wavefront import Wave
from ..tracer.world import World


@dataclass
class ShadowRays:
    """The shadow rays towards one light, one entry for each ray of the wave."""

    light: int
    ray: Ray
    distance: object  # Float, to the light
    asked: object  # Bool, whether the tracer asks (section 4.3.1, decision L2)


def shadow_rays(world: World, wave: Wave, interaction: Interaction) -> Iterator[ShadowRays]:
    """The shadow rays that `wave` sends where it collided, light by light."""
    arrays = world.arrays
    index = interaction.hit.index
    met = (wave.weight > 0) & (index < world.object_count)
    material = world.material(index, met)
    local_weight = arrays.Float(1)
    for share in (material.reflection, material.transparency):
        if share is not None:
            local_weight = local_weight * (1 - share)
    for light in range(len(world.scene.lights)):
        position, _ = world.light(arrays.count(light))
        to_light = position - interaction.point
        distance = dr.norm(to_light)
        direction = to_light / distance
        asked = met & (local_weight > 0) & (dr.dot(direction, interaction.normal) > 0)
        ray = Ray(interaction.point, direction, wave.ray.sides)
        dr.eval(direction, distance, asked)  # the same numbers for both methods, and for the audit
        yield ShadowRays(light, ray, distance, asked)
