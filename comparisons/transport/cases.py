"""The cases: one effect each, a scene, what Mitsuba makes of it, and what theory says that it must make.

The scenes are built so that nothing but the effect in question happens in them. A new case is a row of CASES.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Collection
from dataclasses import dataclass

import numpy as np

from raytruth.converters.mitsuba import sensor
from raytruth.converters.mitsuba.dressed import (
    FAR,
    area,
    dielectric,
    diffuse,
    document,
    dressed,
    fading_point,
    mirror,
    rgb,
    steady_point,
    sun,
)
from raytruth.converters.mitsuba.radiance import Radiance, radiance
from raytruth.converters.mitsuba.variant import mi
from raytruth.reference_tracer.scene.model import Camera, Light, Material, Object, Scene, Tracing
from raytruth.reference_tracer.scene.placement import is_inside
from raytruth.reference_tracer.surfaces import Plane, Sphere
from raytruth.reference_tracer.tracer.render import Picture

from ..suites import choose
from .document import Effect


@dataclass(frozen=True)
class Case:
    """One comparison with Mitsuba's light transport, deterministic unless it has a ladder of samples."""

    id: str
    title: str
    effect: Effect
    because: str  # one sentence: why theory says so
    scene: Scene
    mitsuba: Callable[[Scene, int, int], Radiance]  # of a scene, samples a pixel, a seed
    predicted: Callable[[Picture], np.ndarray] | None = None
    """From the document's picture to the one that Mitsuba must show, (h, w, 3). None: they must be equal."""
    where: Callable[[Picture], np.ndarray] | None = None
    """From the document's picture to the pixels on which theory speaks, (h, w) bool. None: all."""
    ladder: tuple[int, ...] = ()
    """Samples a pixel, rising: the case is judged as Monte Carlo."""

    @property
    def is_finding(self) -> bool:
        """Whether physics and the document differ here, and the case measures how."""
        return self.predicted is not None


# --- what the scenes are built of -------------------------------------------------------------------------------------
SIZE = {"width": 320, "height": 240}
NOISY = {"width": 160, "height": 120}  # of Monte Carlo cases
LADDER = (16, 64, 256, 1024)  # samples a pixel


def ball(center, r: float, color=(1.0, 1.0, 1.0), **material) -> Object:
    return Object(surface=Sphere(center=center, r=r), material=Material(color=color, **material))


def plane(center, normal, color=(1.0, 1.0, 1.0), **material) -> Object:
    a, b, c = normal
    return Object(surface=Plane(center=center, a=a, b=b, c=c), material=Material(color=color, **material))


def far_light(direction, brightness: float = 0.9) -> Light:
    """A light so far away that its rays are parallel: the document's counterpart of a directional one."""
    length = math.sqrt(sum(c * c for c in direction))
    return Light(position=tuple(FAR * c / length for c in direction), brightness=(brightness,) * 3)


def scene(name: str, objects, lights=(), camera: Camera | None = None, background=(0.0, 0.0, 0.0), **tracing) -> Scene:
    return Scene(name=f"transport-{name}", objects=tuple(objects), lights=tuple(lights), background=background,
                 camera=camera or Camera(position=(0.0, 1.2, -6.0), direction=(0.0, -0.22, 1.0), **SIZE),
                 tracing=Tracing(**{"max_distance": 30.0, **tracing}))


def corner(reflection: float = 0.0) -> list[Object]:
    """Floor, back wall and side wall: every ray of a camera that looks into the corner meets one of them."""
    return [plane((0.0, -1.0, 0.0), (0.0, 1.0, 0.0), (0.9, 0.75, 0.5), reflection=reflection),
            plane((0.0, 0.0, 4.0), (0.0, 0.0, -1.0), (0.35, 0.6, 0.9), reflection=reflection),
            plane((-3.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.8, 0.3, 0.35), reflection=reflection)]


CORNER_LIGHT = far_light((1.0, 1.0, -1.0), 1.6)  # meets all three at one angle; none casts a shadow on another
CORNER_COSINE = 1 / math.sqrt(3)


def corner_camera() -> Camera:
    """Looks straight into the corner: no ray runs along a wall, and no mirror shows a horizon."""
    return Camera(position=(1.7, 3.7, -0.7), direction=(-1.0, -1.0, 1.0), fov=40.0, **SIZE)


def box() -> list[Object]:
    """Four walls, floor and ceiling around the origin: no ray gets out."""
    floor, wall = (0.7, 0.68, 0.6), (0.5, 0.6, 0.75)
    return [plane((0.0, -1.0, 0.0), (0.0, 1.0, 0.0), floor),
            plane((0.0, 4.0, 0.0), (0.0, -1.0, 0.0), (0.85, 0.85, 0.85)),
            plane((0.0, 0.0, 4.0), (0.0, 0.0, -1.0), wall), plane((0.0, 0.0, -7.0), (0.0, 0.0, 1.0), wall),
            plane((-4.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.75, 0.4, 0.35)),
            plane((4.0, 0.0, 0.0), (-1.0, 0.0, 0.0), (0.4, 0.65, 0.4))]


def glow(obj: Object, light: Light = CORNER_LIGHT, cosine: float = CORNER_COSINE) -> list[float]:
    """The radiance (1 - R) color cos(phi) brightness of an object that is evenly lit."""
    share = (1 - obj.material.reflection) * cosine
    return [share * c * b for c, b in zip(obj.material.color, light.brightness)]


def paths(scene: Scene, samples: int, seed: int, materials, lights: dict | None = None, *, depth: int = 24,
          integrator: str = "path") -> Radiance:
    """Mitsuba's picture of `scene`, its objects of `materials`, by paths of up to `depth` segments, none ended by chance."""
    return radiance(dressed(scene, materials, lights), {"type": integrator, "max_depth": depth, "rr_depth": 999},
                    scene.camera, samples, seed)


def direct(scene: Scene, samples: int, seed: int, light: dict) -> Radiance:
    """Stock diffuse surfaces in direct light alone."""
    return radiance(dressed(scene, lambda o: {"bsdf": diffuse(o.material.color)}, {"light": light}), DIRECT, scene.camera,
                    samples, seed)


# --- section 4.3.1: the cosine, and what physics does otherwise with lights -------------------------------------------
DIRECT = {"type": "direct", "bsdf_samples": 0, "emitter_samples": 1}

BALLS = scene("balls", [ball((-1.9, 0.0, 0.0), 1.0, (0.9, 0.25, 0.2)), ball((0.3, 0.4, 0.6), 1.1, (0.3, 0.8, 0.4)),
                        ball((2.4, -0.2, 0.2), 0.9, (0.35, 0.4, 0.95))],
              [far_light((-0.2, 1.5, -2.0))],
              Camera(position=(0.0, 0.6, -6.0), direction=(0.02, -0.07, 1.0), fov=64.0, **SIZE))

LAMP = Light(position=(0.5, 3.0, -2.0), brightness=(0.9, 0.9, 0.9))
LAMP_DISTANCE = 4.0  # at which the physical lamp is as bright as the document's
LAMP_SCENE = scene("lamp", [plane((0.0, -1.0, 0.0), (0.0, 1.0, 0.0), (0.8, 0.8, 0.75)),
                            plane((0.0, 0.0, 5.0), (0.0, 0.0, -1.0), (0.6, 0.7, 0.8)),
                            ball((-1.0, 0.0, 0.5), 1.0, (0.9, 0.4, 0.3))], [LAMP])

ALBEDO, WALL = 0.6, 3.0
BOUNCES = 24  # the series is summed to 6e-6 of its value
FURNACE = scene("furnace", [ball((0.0, 0.0, 0.0), WALL, (ALBEDO, 0.5 * ALBEDO, 0.25 * ALBEDO))],
                [Light(position=(0.0, 0.0, 0.0), brightness=(0.35,) * 3)],
                Camera(position=(0.5, -0.4, -1.0), **SIZE))


def lit_by_sun(scene, samples, seed, *, strength: float = 1.0):
    """Stock diffuse surfaces under a stock directional light; `strength` scales its irradiance."""
    light = sun(scene.lights[0])
    light["irradiance"] = rgb([strength * v for v in light["irradiance"]["value"]])
    return direct(scene, samples, seed, light)


def without_pi(scene, samples, seed):
    """The document's brightness taken for an irradiance."""
    return lit_by_sun(scene, samples, seed, strength=1 / math.pi)


def lit_by_fading_lamp(scene, samples, seed):
    return direct(scene, samples, seed, fading_point(scene.lights[0], LAMP_DISTANCE))


def furnace(scene, samples, seed):
    """A physical lamp in the middle of a ball: at one distance from everything it does not fade."""
    return paths(scene, samples, seed, lambda o: {"bsdf": {"type": "twosided", "inner": diffuse(o.material.color)}},
                 {"lamp": fading_point(scene.lights[0], WALL)}, depth=BOUNCES + 1)


def _faded(picture) -> np.ndarray:
    light = picture.scene.lights[0]
    distance = np.linalg.norm(np.array(light.position) - picture.position, axis=-1)
    return picture.color * (LAMP_DISTANCE / distance[..., None]) ** 2


def _furnace_law(picture) -> np.ndarray:
    albedo = np.array(picture.scene.objects[0].material.color)
    return picture.color * (1 - albedo**BOUNCES) / (1 - albedo)


# --- section 4.3.1: hard shadows, and the light that gets through what is transparent ---------------------------------
GROUND = [plane((0.0, -1.0, 0.0), (0.0, 1.0, 0.0), (0.75, 0.72, 0.65)),
          plane((0.0, 0.0, 5.0), (0.0, 0.0, -1.0), (0.55, 0.65, 0.75))]
GROUND_CAMERA = Camera(position=(0.0, 1.6, -6.0), direction=(0.0, -0.3, 1.0), fov=55.0, **SIZE)
SUN = far_light((-0.8, 1.0, -0.9))

OPAQUE = scene("shadow", GROUND + [ball((-1.3, 0.0, -0.5), 0.9, (0.9, 0.35, 0.25)),
                                   ball((0.6, 0.6, -1.2), 0.45, (0.3, 0.75, 0.4)),
                                   ball((1.7, -0.3, 1.0), 0.7, (0.4, 0.45, 0.95))], [SUN], GROUND_CAMERA)
THROUGH = 0.6
CLEAR = scene("clear-shadow", GROUND + [ball((-1.0, 0.0, -0.5), 0.95, (0.3, 0.5, 1.0), transparency=THROUGH),
                                        ball((1.4, -0.2, 0.4), 0.8, (0.95, 0.5, 0.2))], [SUN],
              GROUND_CAMERA.model_copy(update=NOISY))


def veiled(scene, samples, seed, *, opacity=lambda transparency: 1 - transparency):
    """Stock surfaces behind a stock mask; one reflection by a diffuse surface and no more, as in the document."""
    def material(obj):
        surface = {"type": "twosided", "inner": diffuse(obj.material.color)}
        through = obj.material.transparency
        return {"bsdf": {"type": "mask", "opacity": opacity(through), "inner": surface} if through else surface}

    return paths(scene, samples, seed, material, {"sun": sun(scene.lights[0])}, depth=2, integrator="volpath")


# --- section 4.3.2: mirrors that keep all their light -----------------------------------------------------------------
PLANET = scene("mirror", [ball((0.0, 0.3, 0.0), 1.0, reflection=1.0), ball((0.0, -7.2, 0.5), 6.5, (0.85, 0.7, 0.45))],
               [far_light((-0.7, 1.2, -1.0))], Camera(position=(0.0, 1.5, -5.0), direction=(0.0, -0.25, 1.0), fov=55.0, **SIZE))
COMPANY = scene("mirrors", box() + [ball((0.2, 0.1, 1.2), 1.1, reflection=1.0),
                                    ball((1.7, -0.6, -0.4), 0.4, reflection=1.0),
                                    ball((-2.0, -0.2, 0.4), 0.8, (0.9, 0.25, 0.2)),
                                    ball((0.5, -0.7, -2.2), 0.3, (0.25, 0.8, 0.35)),
                                    ball((-0.8, -0.6, -1.6), 0.4, (0.9, 0.8, 0.3))],
                [Light(position=(-2.0, 3.4, -3.0), brightness=(0.95, 0.95, 0.95))],
                Camera(position=(0.0, 1.2, -6.0), direction=(0.0, -0.2, 1.0), fov=50.0, **SIZE), max_depth=6)


def mirrored(scene, samples, seed, *, depth: int = 3):
    """All stock: the path camera, mirror, diffuse ball, sun has three segments before the last."""
    material = lambda o: {"bsdf": mirror() if o.material.reflection else diffuse(o.material.color)}
    return paths(scene, samples, seed, material, {"sun": sun(scene.lights[0])}, depth=depth)


def mirrored_in_company(scene, samples, seed, *, plain=lambda o: document(o.material)):
    """Stock mirrors among bodies that light reaches and leaves once; `plain` is the material of those."""
    return paths(scene, samples, seed, lambda o: {"bsdf": mirror() if o.material.reflection else plain(o)},
                 {"lamp": steady_point(scene.lights[0])}, depth=scene.tracing.max_depth + 2)


# --- section 4.3.3.2: where glass bends rays to, and Fresnel's factors ------------------------------------------------
NEAR_CRITICAL = 1e-2  # of the sine: beside it almost nothing gets through
PATHS = 64  # of which some get through: a dielectric chooses between reflection and refraction


def glass(n: float, size: dict | None = None, balls: int = 2):
    camera = corner_camera().model_copy(update=size or {})
    both = [ball((-1.2, 0.9, 2.1), 1.0, transparency=1.0, refractive_index=n),
            ball((0.1, 1.6, 1.1), 0.5, transparency=1.0, refractive_index=n)]
    # glass turns some rays along a wall: they meet it far away
    return scene(f"glass-n{n:g}", corner() + both[:balls], [CORNER_LIGHT], camera, max_depth=20, max_distance=300.0)


def in_glass(scene, samples, seed, *, reflected: float, light=glow):
    """Glowing walls behind stock glass that reflects the share `reflected` of what Fresnel lets it."""
    def material(obj):
        if obj.material.transparency:
            return {"bsdf": dielectric(obj.material.refractive_index, reflected)}
        return {"bsdf": diffuse((0, 0, 0)), "emitter": area(light(obj))}

    return paths(scene, samples, seed, material)


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


# --- section 4.3.3.1: beyond the critical angle -----------------------------------------------------------------------
# the corner under water, seen from below the surface
WATER = scene("water", corner() + [plane((0.0, 1.6, 0.0), (0.0, 1.0, 0.0), transparency=1.0, refractive_index=1.33)],
              [CORNER_LIGHT], Camera(position=(2.0, -0.2, -2.5), direction=(-0.75, 0.5, 1.0), fov=60.0, **SIZE),
              max_depth=20, max_distance=300.0)


def reflecting(scene, samples, seed):
    """Stock glass that reflects as Fresnel's equations say: everything, beyond the critical angle."""
    return in_glass(scene, samples, seed, reflected=1.0)


def _beyond(picture):
    return totally_reflected(picture, 1e-3)


# --- section 4.3.4: local colour, reflection and refraction in one pixel ----------------------------------------------
KALEIDOSCOPE = scene("kaleidoscope", corner(reflection=0.55), [CORNER_LIGHT], corner_camera(), max_depth=8)

EVERYTHING = scene(
    "everything",
    box() + [ball((-1.7, 0.0, 1.2), 1.0, (0.9, 0.6, 0.3), reflection=0.6),
             ball((1.0, 0.1, -0.6), 1.1, (0.5, 0.8, 0.9), transparency=0.75, reflection=0.5, refractive_index=1.4),
             ball((-0.7, -0.3, -1.6), 0.7, (0.9, 0.3, 0.6), transparency=0.5, reflection=0.5, refractive_index=0.8)],
    [Light(position=(-2.0, 3.5, -3.0), brightness=(0.9, 0.9, 0.9))],
    Camera(position=(0.0, 1.0, -5.5), direction=(0.0, -0.2, 1.0), fov=50.0, **NOISY), max_depth=4)


def glowing_mirrors(scene, samples, seed, *, glow=glow):
    """Half mirrors whose local colour is their own light."""
    return paths(scene, samples, seed, lambda o: {"bsdf": mirror(o.material.reflection), "emitter": area(glow(o))},
                 depth=scene.tracing.max_depth + 1)


def everything(scene, samples, seed, *, brighter: float = 1.0, integrator: str = "volpath"):
    """The whole model: materials and light by plugins of ours, the transport Mitsuba's. `brighter` scales the light."""
    light = scene.lights[0]
    light = light.model_copy(update={"brightness": tuple(brighter * b for b in light.brightness)})
    return paths(scene, samples, seed, lambda o: {"bsdf": document(o.material)}, {"lamp": steady_point(light)},
                 depth=scene.tracing.max_depth + 2, integrator=integrator)


# --- section 5: n x n samples a pixel ---------------------------------------------------------------------------------
SAMPLED = OPAQUE.traced_with(samples=4).model_copy(update={"name": "transport-multisampling"})


def filmed(scene: Scene, samples: int, seed: int) -> Radiance:
    """Mitsuba's own sensor and box filter; its sampler takes the middle of each of the n x n cells of a pixel."""
    lit = dressed(scene, lambda o: {"bsdf": diffuse(o.material.color)}, {"sun": sun(scene.lights[0])})
    per_pixel = scene.tracing.samples**2
    image = mi.render(lit, sensor=sensor(scene.camera, per_pixel), integrator=mi.load_dict(DIRECT), spp=per_pixel,
                      seed=seed)
    mean = np.array(image, dtype=float)
    return Radiance(mean, np.zeros_like(mean), per_pixel)


CASES = (
    Case("diffuse", "Diffuse balls in parallel light", "shading",
         "A Lambertian surface of albedo c reflects c/pi of its irradiance; a far light of irradiance pi b therefore "
         "gives c b cos(phi), the document's visibleColor.", BALLS, lit_by_sun),
    Case("one-over-pi", "Brightness taken for irradiance", "shading",
         "Physics divides by pi what the document does not: an irradiance of b gives the document's picture over pi.",
         BALLS, without_pi, predicted=lambda picture: picture.color / math.pi),
    Case("fall-off", "A lamp that fades with distance", "shading",
         "A physical point light fades with the square of its distance r, the document's does not: the pictures differ "
         f"by ({LAMP_DISTANCE:g}/r)^2, where both lamps are equally bright at r = {LAMP_DISTANCE:g}.",
         LAMP_SCENE, lit_by_fading_lamp, predicted=_faded),
    Case("interreflection", "Light that diffuse walls throw on each other", "shading",
         "In the document diffuse light ends at the eye; in physics it lights other walls. In a hollow ball with the "
         "lamp in its middle every further bounce adds the same factor a, the albedo: together 1/(1 - a).",
         FURNACE, furnace, predicted=_furnace_law),
    Case("hard-shadow", "Shadows of opaque balls", "shadow",
         "Parallel light is blocked or not; Mitsuba's integrator of direct light traces one shadow ray and lets "
         "nothing else in.",
         OPAQUE, lit_by_sun),
    Case("clear-shadow", "The shadow of a clear ball", "shadow",
         "A mask of opacity 1 - T lets a path pass with probability T and a shadow ray with weight T at every "
         "crossing, in and out: at n = 1 its mean is the document's mixing and its shadow has intensity T^2.",
         CLEAR, veiled, ladder=LADDER),
    Case("mirror", "A mirror ball above a diffuse one", "reflection",
         "A conductor without a material reflects all light; with one convex diffuse body there is nothing that it "
         "could throw light on but the mirror, and three segments of a path leave no room for that.", PLANET, mirrored),
    Case("mirrors", "Two mirrors in a lit room", "reflection",
         "Stock diffuse bodies would light each other, and a stock lamp would fade; with a material that is evaluated "
         "for lights and never sampled, and a lamp that does not fade, the mirrors are Mitsuba's own.",
         COMPANY, mirrored_in_company),
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
    Case("total-reflection-inside", "Under water, n = 1.33", "total reflection",
         "Beyond the critical angle Fresnel's equations reflect everything, as the document does; there a stock "
         "dielectric has no choice to make, and one sample is exact.", WATER, reflecting, where=_beyond),
    Case("total-reflection-outside", "A bubble, n = 0.8", "total reflection",
         "The same from outside: the rim of a bubble thinner than air mirrors.",
         glass(0.8, balls=1), reflecting, where=_beyond),
    Case("mirror-blend", "Three half mirrors in a corner", "mixing",
         "A surface that glows with (1 - R) color cos(phi) brightness and mirrors with R is the document's mixing; "
         "evenly lit planes glow evenly, and the corner shows them in each other.",
         KALEIDOSCOPE, glowing_mirrors),
    Case("everything", "The whole model at once", "mixing",
         "Given the document's light and material, each of Mitsuba's paths chooses reflection or refraction by its "
         "weight and divides by that chance: the mean over paths is the document's recursion.",
         EVERYTHING, everything, ladder=LADDER),
    Case("multisampling", "4 × 4 samples a pixel", "multisampling",
         "Mitsuba's stratified sampler without jitter takes the centres of n x n cells, and its box filter their mean: "
         "the document's samples; direct light makes no further choice at random.", SAMPLED, filmed),)


def find(ids: Collection[str]) -> tuple[Case, ...]:
    """The cases called `ids`; all, if there are none. Raises InputError."""
    return choose(ids, {case.id: case for case in CASES}, "unknown case")
