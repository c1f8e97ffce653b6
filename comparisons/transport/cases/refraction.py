"""Section 4.3.3.2: where glass bends rays to, with Fresnel's factors divided out; and those factors by themselves."""

from __future__ import annotations

import numpy as np

from converters.mitsuba.dressed import area, dielectric, diffuse, dressed
from converters.mitsuba.radiance import Radiance, radiance
from reference_tracer.scene.placement import is_inside

from ..case import Case
from .rooms import CORNER_LIGHT, LADDER, NOISY, ball, corner, corner_camera, glow, scene

PATH = {"type": "path", "max_depth": 24, "rr_depth": 999}
NEAR_CRITICAL = 1e-2  # of the sine: almost nothing gets through
PATHS = 64  # of which some get through: a dielectric chooses between reflection and refraction


def glass(n: float, size: dict | None = None, balls: int = 2):
    camera = corner_camera().model_copy(update=size or {})
    both = [ball((-1.2, 0.9, 2.1), 1.0, transparency=1.0, refractive_index=n),
            ball((0.1, 1.6, 1.1), 0.5, transparency=1.0, refractive_index=n)]
    # glass turns some rays along a wall: they meet it far away
    return scene(f"glass-n{n:g}", corner() + both[:balls], [CORNER_LIGHT], camera, max_depth=20, max_distance=300.0)


def in_glass(scene, samples, seed, *, reflected: float, light=glow):
    """Glowing walls behind stock glass that reflects the share `reflected` of what Fresnel lets it."""
    def dress(obj):
        if obj.material.transparency:
            return {"bsdf": dielectric(obj.material.refractive_index, reflected)}
        return {"bsdf": diffuse((0, 0, 0)), "emitter": area(light(obj))}

    return radiance(dressed(scene, dress), PATH, scene.camera, samples, seed)


def ratio(scene, samples, seed):
    """What glass transmits of the walls over what it transmits of a world of radiance one, along the same paths."""
    of_walls = in_glass(scene, PATHS, seed, reflected=0.0).mean
    of_ones = in_glass(scene, PATHS, seed, reflected=0.0, light=lambda obj: (1.0, 1.0, 1.0)).mean
    of_each = np.divide(of_walls, of_ones, out=np.zeros_like(of_walls), where=of_ones > 0)
    return Radiance(of_each, np.zeros_like(of_each), PATHS)


def raw(scene, samples, seed):
    """Stock glass as it is, without what it reflects."""
    return in_glass(scene, samples, seed, reflected=0.0)


def fresnel(cos1: np.ndarray, n: float) -> np.ndarray:
    """The share of unpolarised light that a surface reflects (Born & Wolf, Principles of Optics, 1.5.2); 1 beyond the
    critical angle."""
    cos2 = np.sqrt(np.maximum(1 - (1 - cos1**2) / n**2, 0))
    s, p = (cos1 - n * cos2) / (cos1 + n * cos2), (n * cos1 - cos2) / (n * cos1 + cos2)
    return (s**2 + p**2) / 2


def incidence(picture) -> np.ndarray:
    """cos(phi1) of every pixel's first hit; 1 where there is none."""
    ray = picture.position - np.array(picture.scene.camera.position)
    return np.nan_to_num(-np.sum(ray * picture.normal, axis=-1) / np.linalg.norm(ray, axis=-1), nan=1.0)


def critical(picture) -> np.ndarray:
    """n2 / n1 where a camera ray hits first: beyond this sine of the angle it is totally reflected."""
    camera = picture.scene.camera.position
    ratios = [1 / o.material.refractive_index if is_inside(o, camera) else o.material.refractive_index
              for o in picture.scene.objects]
    return np.array(ratios + [1.0])[picture.index]


def totally_reflected(picture, margin: float = 0.0) -> np.ndarray:
    """Pixels whose camera ray is totally reflected where it first hits; `margin` of the sine keeps away from the angle
    at which rounding decides."""
    sine = np.sqrt(np.maximum(1 - incidence(picture) ** 2, 0))
    return on(picture, transparent=True) & (sine > critical(picture) + margin)


def on(picture, transparent: bool) -> np.ndarray:
    """Pixels whose first hit is on glass, or not."""
    clear = np.array([o.material.transparency > 0 for o in picture.scene.objects] + [False])
    return clear[picture.index] == transparent


def _dimmed(picture) -> np.ndarray:
    """Two surfaces at the same angle: a ray through a ball leaves as it came."""
    n = max(o.material.refractive_index for o in picture.scene.objects)
    passed = (1 - fresnel(incidence(picture), n)) ** 2
    return picture.color * np.where(on(picture, transparent=True), passed, 1.0)[..., None]


def _through_one_ball(picture) -> np.ndarray:
    """Pixels whose ray goes through at most one ball: two secondary generations."""
    return picture.depth <= 2


def _transmitting(picture) -> np.ndarray:
    """Where enough of the PATHS get through; next to the rim none does."""
    n = max(o.material.refractive_index for o in picture.scene.objects)
    return ~on(picture, transparent=True) | (fresnel(incidence(picture), n) < 0.5)


CASES = (
    Case("refraction", "Glass, n = 1.4", "refraction",
         "A stock dielectric that reflects nothing sends every path that gets through along the document's rays; "
         "Fresnel's factors are the same for walls of radiance one, and drop out of the ratio.",
         glass(1.4), ratio, where=_transmitting),
    Case("refraction-thin", "A bubble, n = 0.8", "refraction",
         "The same for a bubble thinner than the air around it, where rays bend outward; where total reflection lets "
         "nothing through, the ratio says nothing.", glass(0.8, balls=1), ratio,
         where=lambda picture: ~totally_reflected(picture, -NEAR_CRITICAL)),
    Case("fresnel", "What Fresnel's factors take away", "refraction",
         "A physical surface transmits the share 1 - F of Fresnel's equations, the document's all of it. A ball is "
         "left at the angle at which it was entered: (1 - F)^2 gets through.",
         glass(1.4, NOISY), raw, predicted=_dimmed, where=_through_one_ball, ladder=LADDER),
)
