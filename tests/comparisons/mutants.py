"""Renderers that are wrong on purpose. Each is the reference with a fault that enters where a renderer is put together: the
scene it is given, the world its kernels ask, the planes it leaves."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import drjit as dr
import numpy as np

from raytruth.reference_tracer.scene.load import parse_scene
from raytruth.reference_tracer.scene.model import Scene
from raytruth.reference_tracer.tracer import render as rendering
from raytruth.reference_tracer.tracer.rays import Ray
from raytruth.reference_tracer.tracer.render import Picture
from raytruth.reference_tracer.tracer.world import World

SCENE = parse_scene(b"""{"name": "mixed", "camera": {"width": 96, "height": 72}, "background": [0.1, 0.15, 0.2],
    "objects": [{"surface": {"type": "plane", "center": [0, -1, 0], "a": 0, "b": 1, "c": 0}, "material": {"color": [0.6, 0.7, 0.5]}},
                {"surface": {"type": "sphere", "center": [-1.1, -0.1, 4.5], "r": 0.9}, "material": {"color": [0.9, 0.3, 0.2]}},
                {"surface": {"type": "sphere", "center": [1.2, 0.2, 5.5], "r": 1.1},
                 "material": {"color": [0.8, 0.8, 0.9], "reflection": 0.6}},
                {"surface": {"type": "sphere", "center": [0.4, -0.45, 3.2], "r": 0.5},
                 "material": {"color": [0.2, 0.5, 0.9], "transparency": 0.7, "refractive_index": 1.4}}],
    "lights": [{"position": [3, 4, 0], "brightness": [0.7, 0.7, 0.6]}, {"position": [-4, 3, 2], "brightness": [0.2, 0.3, 0.4]}],
    "tracing": {"max_distance": 20, "max_depth": 2}}""")
FLOOR, MATTE, MIRROR, GLASS = range(4)
Make = Callable[[Scene], Picture]

_pictures: dict[str, Picture] = {}


def right(scene: Scene) -> Picture:
    """The reference, each scene once."""
    if scene.hash not in _pictures:
        _pictures[scene.hash] = rendering.render(scene, "exact")
    kept = _pictures[scene.hash]
    planes = ("color", "t", "position", "normal", "index", "depth", "status")
    return replace(kept, scene=scene, metadata=dict(kept.metadata), **{name: getattr(kept, name).copy() for name in planes})


def given(change: Callable[[Scene], Scene]) -> Make:
    """Another scene in place of the right one."""
    return lambda scene: replace(right(change(scene)), scene=scene)


def leaving(spoil: Callable[[Picture], None]) -> Make:
    """Other planes in place of the right ones."""
    def make(scene: Scene) -> Picture:
        picture = right(scene)
        spoil(picture)
        return picture
    return make


def asking(**answers) -> Make:
    """Another world in place of the right one: methods that take its place."""
    kind = type("Wrong", (World,), answers)
    return lambda scene: rendering.Renderer(scene, "exact", world=kind).picture()


# --- scenes ------------------------------------------------------------------------------------------------------------
def _camera(**changes):
    return lambda scene: scene.model_copy(update={"camera": scene.camera.model_copy(update=changes)})


def _material(k: int, **changes):
    """Of the object at the place of object k in SCENE, wherever it is asked."""
    def change(scene: Scene) -> Scene:
        found = []
        for obj in scene.objects:
            mine = obj.surface.center == SCENE.objects[k].surface.center
            new = {name: change(getattr(obj.material, name)) for name, change in changes.items()} if mine else {}
            found.append(obj.model_copy(update={"material": obj.material.model_copy(update=new)}))
        return scene.model_copy(update={"objects": tuple(found)})
    return change


def _surface(k: int, **changes):
    def change(scene: Scene) -> Scene:
        return scene.model_copy(update={"objects": tuple(
            o.model_copy(update={"surface": o.surface.model_copy(update={n: c(getattr(o.surface, n)) for n, c in changes.items()})})
            if o.surface.center == SCENE.objects[k].surface.center else o for o in scene.objects)})
    return change


def _lights(change):
    return lambda scene: scene.model_copy(update={"lights": tuple(change(list(scene.lights)))})


def _swapped(lights):
    """Positions stay, brightnesses change places."""
    return [light.model_copy(update={"brightness": other.brightness}) for light, other in zip(lights, lights[::-1])]


def _without(effect: str):
    return lambda scene: scene.traced_with(effects=tuple(e for e in scene.tracing.effects if e != effect))


def _shallower(scene: Scene) -> Scene:
    return scene.traced_with(max_depth=max(scene.tracing.max_depth - 1, 0))


def _missing(scene: Scene) -> Picture:
    """Without the matte ball."""
    kept = [k for k, o in enumerate(scene.objects) if o.surface.center != SCENE.objects[MATTE].surface.center]
    picture = right(scene.model_copy(update={"objects": tuple(scene.objects[k] for k in kept)}))
    return replace(picture, scene=scene, index=np.array([*kept, -1], np.int32)[picture.index])


# --- planes ------------------------------------------------------------------------------------------------------------
def _inner(picture: Picture) -> tuple[int, int]:
    """A pixel in the middle of an object."""
    rows, cols = np.nonzero(picture.index == picture.index.max())
    return int(np.median(rows)), int(np.median(cols))


def _one_pixel(picture):
    picture.color[_inner(picture)] += 0.01


def _not_a_number(picture):
    picture.color[_inner(picture)] = np.nan


def _pixel_of_another_object(picture):
    picture.index[_inner(picture)] = 0


def _unhit(picture, mask):
    picture.index[mask], picture.t[mask], picture.status[mask] = -1, np.inf, 0
    picture.normal[mask], picture.position[mask], picture.color[mask] = np.nan, np.nan, picture.scene.background


def _hole(picture):
    row, col = _inner(picture)
    mask = np.zeros(picture.t.shape, bool)
    mask[row - 1:row + 2, col - 1:col + 2] = True
    _unhit(picture, mask)


def _every(change):
    def spoil(picture):
        for name in ("color", "t", "position", "normal", "index", "depth", "status"):
            setattr(picture, name, change(getattr(picture, name)))
    return spoil


def _color(change):
    def spoil(picture):
        picture.color = change(picture.color)
    return spoil


def _renumbered(numbers):
    def spoil(picture):
        if len(picture.scene.objects) == len(SCENE.objects):
            picture.index = np.array([*numbers, -1], np.int32)[picture.index]
    return spoil


def _farther(picture):
    picture.t = picture.t * (1 + 1e-3)


def _elsewhere(picture):
    picture.position = picture.position + [1e-3, 0, 0]


def _unturned(picture):
    picture.normal = -picture.normal


def _generation(picture):
    picture.depth = picture.depth + 1


def _stale(scene: Scene) -> Picture:
    """The planes of the scene before this one, whatever is asked."""
    other = _surface(MATTE, center=lambda c: (c[0] + 0.4, c[1], c[2]))(SCENE)
    return replace(right(other.resized(scene.camera.width, scene.camera.height)), scene=scene)


def _speckled(picture):
    """Every seventh lit pixel is in its own shadow."""
    met = np.flatnonzero(picture.index >= 0)[::7]
    picture.color.reshape(-1, 3)[met] = 0


# --- worlds ------------------------------------------------------------------------------------------------------------
def _lost_on_one_side(self, ray):
    hit = World.nearest(self, ray)
    lost = ray.d.x <= 0
    hit.index = dr.select(lost, self.object_count, hit.index)
    return hit


def _one_decimal(self, ray):
    hit = World.nearest(self, ray)
    hit.t = dr.select(hit.index < self.object_count, dr.round(hit.t * 10) / 10, hit.t)
    return hit


def _tilted(self, point, index, active):
    """The matte ball's normals are a degree off."""
    normal = World.normal(self, point, index, active)
    c, s = float(np.cos(np.radians(1))), float(np.sin(np.radians(1)))
    turned = type(normal)(c * normal.x + s * normal.z, normal.y, -s * normal.x + c * normal.z)
    return dr.select(index == MATTE, turned, normal) if self.object_count > MATTE else normal


def _as_stored(self, point, index, active):
    """Normals in bytes."""
    return dr.normalize(dr.round(World.normal(self, point, index, active) * 127) / 127)


def _on_the_other_side(self, ray, distance, active):
    """Shadow rays mirrored left to right."""
    return World.transmittance(self, Ray(ray.o, type(ray.d)(-ray.d.x, ray.d.y, ray.d.z), ray.sides), distance, active)


def _through_once(self, ray, distance, active):
    intensity, unsure = World.transmittance(self, ray, distance, active)
    return dr.sqrt(intensity), unsure  # T instead of T^2: every way through a ball crosses twice


def _through_all(self, ray, distance, active):
    intensity, unsure = World.transmittance(self, ray, distance, active)
    return dr.maximum(intensity, 0.05), unsure


def _brighter(self, j):
    position, brightness = World.light(self, j)
    return position, brightness * 1.01


@dataclass(frozen=True)
class Mutant:
    make: Make
    stage: str | None  # what attribution must name; None where a few pixels alone, or planes it does not ask for, are wrong


def _claimed(picture: Picture) -> Picture:
    picture.metadata["precision"] = 64
    return picture


MUTANTS = {
    "one interior pixel": Mutant(leaving(_one_pixel), None),
    "NaN in one pixel": Mutant(leaving(_not_a_number), None),
    "one pixel of another object": Mutant(leaving(_pixel_of_another_object), None),
    "generations off by one": Mutant(leaving(_generation), None),
    "single precision that claims to be double": Mutant(lambda scene: _claimed(rendering.render(scene, precision=32)), None),
    "a hole of nine pixels": Mutant(leaving(_hole), "hit"),
    "hits lost on one side": Mutant(asking(nearest=_lost_on_one_side), "hit"),
    "one object missing": Mutant(_missing, "hit"),
    "objects swapped": Mutant(leaving(_renumbered([1, 0, 2, 3])), "hit"),
    "objects off by one": Mutant(leaving(_renumbered([1, 2, 3, 0])), "hit"),
    "stale planes of another scene": Mutant(_stale, "hit"),
    "rays that end early": Mutant(given(lambda s: s.traced_with(max_distance=5.0)), "hit"),
    "shifted by a pixel": Mutant(leaving(_every(lambda p: np.roll(p, 1, axis=1))), "camera"),
    "shifted down by a pixel": Mutant(leaving(_every(lambda p: np.roll(p, 1, axis=0))), "camera"),
    "rows from the bottom": Mutant(leaving(_every(lambda p: p[::-1].copy())), "camera"),
    "mirrored": Mutant(leaving(_every(lambda p: p[:, ::-1].copy())), "camera"),
    "field of view over the shorter side": Mutant(given(lambda s: _camera(fov=2 * np.degrees(np.arctan(
        np.tan(np.radians(s.camera.fov) / 2) * max(s.camera.width, s.camera.height) / min(s.camera.width, s.camera.height))))(s)),
        "camera"),
    "positions off their rays": Mutant(leaving(_elsewhere), "camera"),
    "distances a thousandth too long": Mutant(leaving(_farther), "root"),
    "a ball a thousandth too small": Mutant(given(_surface(MATTE, r=lambda r: 0.999 * r)), "root"),
    "a ball a thousandth off its place": Mutant(given(_surface(MIRROR, center=lambda c: (c[0], c[1], c[2] + 1e-3))), "root"),
    "roots to one decimal": Mutant(asking(nearest=_one_decimal), "root"),
    "normals of one object a degree off": Mutant(asking(normal=_tilted), "normal"),
    "normals in bytes": Mutant(asking(normal=_as_stored), "normal"),
    "normals not turned": Mutant(leaving(_unturned), "normal"),
    "red two percent too bright": Mutant(leaving(_color(lambda c: c * [1.02, 1, 1])), "shading"),
    "gamma applied": Mutant(leaving(_color(lambda c: c ** (1 / 2.2))), "shading"),
    "colours clipped": Mutant(leaving(_color(lambda c: np.minimum(c, 0.5))), "shading"),
    "red and blue exchanged": Mutant(given(lambda s: _material(MATTE, color=lambda c: c[::-1])(s)), "shading"),
    "brightnesses of lights exchanged": Mutant(given(_lights(_swapped)), "shading"),
    "lights a hundredth too bright": Mutant(asking(light=_brighter), "shading"),
    "one light missing": Mutant(given(_lights(lambda lights: lights[:1])), "shading"),
    "no shadows": Mutant(given(_without("shadow")), "shadow"),
    "shadows on the wrong side": Mutant(asking(transmittance=_on_the_other_side), "shadow"),
    "surfaces in their own shadow": Mutant(leaving(_speckled), "shadow"),
    "transparency once in shadows": Mutant(asking(transmittance=_through_once), "shadow"),
    "shadows never quite dark": Mutant(asking(transmittance=_through_all), "shadow"),
    "reflection weighed too little": Mutant(given(_material(MIRROR, reflection=lambda r: 0.95 * r)), "reflection"),
    "no reflection": Mutant(given(_without("reflection")), "reflection"),
    "no refraction": Mutant(given(_without("refraction")), "refraction"),
    "indices of refraction turned over": Mutant(given(_material(GLASS, refractive_index=lambda n: 1 / n)), "refraction"),
    "law of refraction as printed": Mutant(given(lambda s: s.traced_with(refraction="as_printed")), "refraction"),
    "one generation too few": Mutant(given(_shallower), "refraction"),
    "background too bright": Mutant(given(lambda s: s.model_copy(update={"background": tuple(1.1 * c for c in s.background)})),
                                    "reflection"),
}
