"""Scenes derived from a scene, each of which leaves all later stages of section 4 nothing to do."""

from __future__ import annotations

import numpy as np

from raytruth.reference_tracer.scene.model import Camera, Light, Material, Object, Scene
from raytruth.reference_tracer.scene.placement import is_inside
from raytruth.reference_tracer.tracer.camera import canvas_point, frame

BLACK, WHITE = (0.0, 0.0, 0.0), (1.0, 1.0, 1.0)
WITHIN = {"fov": 110.0, "width": 96, "height": 96}  # of a picture taken inside an object
CHORDS, DEEP = 24, 64  # pixels tried, points tried behind each


def _opaque(m: Material) -> Material:
    return Material(color=m.color)


def _white(m: Material) -> Material:
    return Material(color=WHITE)


def _with(scene: Scene, material, **changes) -> Scene:
    objects = tuple(o.model_copy(update={"material": material(o.material)}) for o in scene.objects)
    return scene.model_copy(update={"objects": objects, **changes})


def _first_generation(scene: Scene) -> Scene:
    """One sample, no secondary rays, nothing behind the objects."""
    return scene.traced_with(samples=1, max_depth=0).model_copy(update={"background": BLACK})


def _lit_from_camera(scene: Scene) -> dict:
    """A light that no point seen by the camera can be in the shadow of."""
    return {"lights": (Light(position=scene.camera.position, brightness=WHITE),)}


def _lights_alone(scene: Scene) -> Scene:
    """Without ambient light (decision F2), in which nothing is dark: `local` asks for it, and how it and lights combine."""
    return scene.traced_with(ambient=0.0)


def geometry(scene: Scene) -> Scene:
    """White opaque objects, one light at the camera: the colour is cos(phi1), and nothing is in shadow."""
    return _with(_lights_alone(_first_generation(scene)), _white, **_lit_from_camera(scene))


def lights_apart(scene: Scene) -> list[Scene]:
    """White opaque objects under the scene's lights: up to three at a time, each in a channel of its own."""
    base = _with(_lights_alone(_first_generation(scene)), _white)
    lights = scene.lights
    return [base.model_copy(update={"lights": tuple(
        Light(position=light.position, brightness=tuple(float(k == channel) for k in range(3)))
        for channel, light in enumerate(lights[start:start + 3]))}) for start in range(0, len(lights), 3)]


def local(scene: Scene) -> Scene:
    """The scene's colours and lights, ambient light among them, on opaque objects."""
    return _with(_first_generation(scene), _opaque)


def shadows(scene: Scene) -> Scene:
    """Nothing is a mirror, nothing is seen through an object, but light passes through them."""
    return _with(_first_generation(scene), lambda m: Material(color=m.color, transparency=m.transparency))


def weights(scene: Scene) -> Scene:
    """The scene's materials without secondary rays, lit from the camera: the colour is cos(phi1) times their weights."""
    return _lights_alone(_first_generation(scene)).model_copy(update=_lit_from_camera(scene))


def mirrors(scene: Scene) -> Scene:
    """What reflects is a perfect black mirror, all else is opaque: the light of a mirror is its reflection ray's."""
    return _with(scene.traced_with(samples=1),
                 lambda m: Material(color=BLACK, reflection=1.0) if m.reflection > 0 else _opaque(m))


def glass(scene: Scene) -> Scene:
    """What is transparent is perfectly clear, all else is opaque: only refraction and total reflection are left."""
    return _with(scene.traced_with(samples=1),
                 lambda m: Material(color=BLACK, transparency=1.0, refractive_index=m.refractive_index)
                 if m.transparency > 0 else _opaque(m))


def whole(scene: Scene) -> Scene:
    return scene.traced_with(samples=1)


def within(scene: Scene, k: int, planes: dict[str, np.ndarray]) -> Scene | None:
    """Object `k` alone, white, seen and lit from a point inside it; None where no such point is found.

    Rays that were refracted meet surfaces from within: there the normal has to be turned (decision N1).
    """
    obj = scene.objects[k]
    point = _point_inside(scene, obj, np.argwhere(planes["index"] == k), planes)
    if point is None:
        return None
    camera = Camera(position=tuple(map(float, point)), direction=scene.camera.direction, up=scene.camera.up, **WITHIN)
    alone = scene.model_copy(update={"camera": camera, "objects": (obj,)})
    return geometry(alone)


def _point_inside(scene: Scene, obj: Object, pixels: np.ndarray, planes) -> np.ndarray | None:
    """The middle of the longest way that rays of some pixels have inside the object."""
    center = np.array(obj.surface.center)
    if is_inside(obj, center):
        return center
    directions = pixel_directions(scene)
    best, found = 0, None
    for row, col in pixels[::max(1, len(pixels) // CHORDS)]:
        d, t = directions[row, col], planes["t"][row, col]
        ways = t + (np.arange(DEEP) + 0.5) * t / DEEP
        inside = np.array([is_inside(obj, np.array(scene.camera.position) + way * d) for way in ways])
        length = int(np.argmin(inside)) if not inside.all() else DEEP
        if length > best:
            best, found = length, np.array(scene.camera.position) + 0.5 * (t + ways[length - 1]) * d
    return found


def pixel_directions(scene: Scene) -> np.ndarray:
    """The unit directions of section 2 through the pixels' centres, (h, w, 3)."""
    f = frame(scene.camera)
    row, col = np.mgrid[:scene.camera.height, :scene.camera.width].astype(float)
    x, y = canvas_point(f, row, col, 0, 0, 1)
    d = x[..., None] * f.v_x + y[..., None] * f.v_y + f.v_dir
    return d / np.linalg.norm(d, axis=-1, keepdims=True)
