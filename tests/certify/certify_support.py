"""What the tests of certify share: small scenes and deliberately broken methods."""

from __future__ import annotations

import json

import drjit as dr

from raytruth.reference_tracer import first_hit
from raytruth.reference_tracer.scene.load import parse_scene
from raytruth.reference_tracer.scene.model import Scene


def thing(kind: str, center=(0, 0, 0), material: dict | None = None, name: str = "", rotation: dict | None = None,
          **surface) -> dict:
    document = {"name": name, "surface": {"type": kind, "center": list(center), **surface}, "material": material or {}}
    return document | ({"rotation": rotation} if rotation else {})


def make_scene(*objects: dict, lights=(((2, 3, -2), 1.0),), size=(24, 18), background=(0, 0, 0), fov=60,
               **tracing) -> Scene:
    document = {"camera": {"width": size[0], "height": size[1], "fov": fov}, "objects": list(objects),
                "lights": [{"position": list(p), "brightness": [b] * 3} for p, b in lights],
                "background": list(background), "tracing": tracing}
    return parse_scene(json.dumps(document).encode(), "test scene")


def mirror_and_glass(**tracing) -> Scene:
    """Every kind of ray: a mirror ball, a ball of glass, a turned ring of glass and a floor."""
    return make_scene(
        thing("sphere", (-0.9, 0, 4), {"color": (1, 0.9, 0.8), "reflection": 0.6}, "mirror ball", r=0.8),
        thing("sphere", (0.8, 0.1, 3), {"reflection": 0.1, "transparency": 0.8, "refractive_index": 1.4}, "glass ball",
              r=0.7),
        thing("torus", (0, -0.4, 2.5), {"transparency": 0.5, "refractive_index": 1.2}, "glass ring",
              {"axis": [1, 0.3, 0], "degrees": 70}, R=0.4, r=0.15),
        thing("plane", (0, -1.07, 0), {"color": (0.9, 1, 1), "reflection": 0.2}, "floor", a=0, b=1, c=0),
        **{"max_depth": 4, "max_distance": 40} | tracing)


class _Wrapped:
    """A method that spoils the answers of another."""

    name = "broken"

    vouches, closed_form = True, False
    variables = ()

    def __init__(self, inner):
        self.inner = inner

    def first(self, solid, ray, inside, limit):
        return self.inner.first(solid, ray, inside, limit)

    def crossings(self, solid, ray, inside, limit, only_first):
        return self.inner.crossings(solid, ray, inside, limit, only_first)

    def radius(self, solid, ray, t, active):
        return self.inner.radius(solid, ray, t, active)


class SkipsRoots(_Wrapped):
    """Loses about every 50th root, chosen by digits of t."""

    def first(self, solid, ray, inside, limit):
        crossing = self.inner.first(solid, ray, inside, limit)
        digits = dr.uint64_array_t(type(limit))(dr.select(crossing.found, crossing.t, 0) * 1e7)
        crossing.found &= digits % 50 != 7
        return crossing


class TakesSideFromSign(_Wrapped):
    """Takes the side of every ray from the sign of f at its origin, which is noise on a surface (against M2)."""

    def first(self, solid, ray, inside, limit):
        return super().first(solid, ray, solid.inside_at(ray, dr.zeros(type(limit))), limit)

    def crossings(self, solid, ray, inside, limit, only_first):
        return super().crossings(solid, ray, solid.inside_at(ray, dr.zeros(type(limit))), limit, only_first)


class IsOff(_Wrapped):
    """Every t is a millionth too large."""

    def first(self, solid, ray, inside, limit):
        crossing = self.inner.first(solid, ray, inside, limit)
        crossing.t = crossing.t + 1e-6
        return crossing


class ClaimsTooMuch(_Wrapped):
    """A proof whose enclosures are a hundred times too narrow."""

    def radius(self, solid, ray, t, active):
        return 0.01 * self.inner.radius(solid, ray, t, active)


def breaking(monkeypatch, method: str, broken: type, instead_of: str = "exact") -> None:
    """From now on `method` is `broken` around the method `instead_of`."""
    choose = first_hit.choose

    def replaced(name, obj, tracing, arrays):
        if name != method:
            return choose(name, obj, tracing, arrays)
        return broken(choose(instead_of, obj, tracing, arrays))

    monkeypatch.setattr(first_hit, "choose", replaced)


class TrustsItsSide(_Wrapped):
    """Believes that every ray starts on the side it is told, whatever f says: a bare change of sign ahead is a crossing."""

    class _Trusted:
        def __init__(self, solid):
            self._solid = solid

        def __getattr__(self, name):
            return getattr(self._solid, name)

        def search_range(self, ray, inside, limit):
            start, stop = self._solid.search_range(ray, inside, limit)
            return dr.maximum(start, 1e-300), stop  # not at the origin: there it would be doubted

    def first(self, solid, ray, inside, limit):
        return super().first(self._Trusted(solid), ray, inside, limit)

    def crossings(self, solid, ray, inside, limit, only_first):
        return super().crossings(self._Trusted(solid), ray, inside, limit, only_first)
