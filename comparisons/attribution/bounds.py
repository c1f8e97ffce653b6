"""How far two faultless renderers may be apart on a scene: on colours, distances, normals and objects, pixel by pixel.

As in reference_tracer.tracer.sensitivity, the bound is measured: every ray is moved by units of rounding, several times
over. For a renderer on meshes a unit is larger: its rays meet surfaces that are elsewhere.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np
from skimage.morphology import dilation

from raytruth.reference_tracer.errors import InputError
from raytruth.reference_tracer.scene.model import Scene
from raytruth.reference_tracer.tracer.render import UNDECIDED, Picture
from raytruth.reference_tracer.tracer.sensitivity import DIRECTION_UNITS, ORIGIN_UNITS, SAFETY, UNIT, Perturbations

PROBES = 5
AROUND = np.ones((3, 3), bool)


@dataclass(frozen=True)
class Accuracy:
    """What a kind of renderer can do. `unit` moves rays, the others are floors of what may differ anywhere."""

    unit: float  # of rounding, relative
    color: float  # relative to 1 + colour
    depth: float  # relative
    normal: float  # length of the difference
    stray: float  # share of the pixels that may leave their bounds: edges that no probe has crossed


SINGLE = Accuracy(UNIT[32], color=2e-5, depth=5e-6, normal=5e-5, stray=3e-4)
ISOSURFACE = replace(SINGLE, color=2e-4, normal=1e-3)  # POV-Ray's, at an accuracy of 1e-8
MESH = Accuracy(UNIT[32], color=1e-3, depth=1e-4, normal=4e-3, stray=5e-3)  # of 256 cells


def accuracy_of(pictures: list[Picture]) -> Accuracy:
    """The accuracy of the least accurate of the renderers that made `pictures`, from what they tell of themselves.

    Raises InputError where that is not measurable.
    """
    facts = [p.metadata for p in pictures]
    for f in facts:
        if f.get("measured_mesh_error", 0) is None:
            raise InputError(f"how far {f['renderer']}'s meshes of {f['scene']} are from the surfaces is not measurable; "
                             "attribution has nothing to hold it to")
    meshed = [float(f["measured_mesh_error"]) for f in facts if f.get("measured_mesh_error")]
    if meshed:
        return replace(MESH, unit=max(MESH.unit, max(meshed) / _moved_by_a_unit(pictures[0])))
    accuracy = ISOSURFACE if any(f.get("isosurfaces") for f in facts) else SINGLE
    # colours of a fixed number of bits are as fine as the brightest of them allows
    return replace(accuracy, color=accuracy.color * max([1.0, *(f["brightest"] for f in facts if f.get("brightest"))]))


def _moved_by_a_unit(picture: Picture) -> float:
    """How far from its place a unit of perturbation moves a typical hit at most."""
    hits = picture.t[picture.index >= 0]
    distance = float(np.median(hits)) if hits.size else 0.0
    return ORIGIN_UNITS * max(1.0, float(np.linalg.norm(picture.scene.camera.position))) + DIRECTION_UNITS * distance


@dataclass(frozen=True)
class Bounds:
    """Bounds of every pixel, (h, w); `decided` is False where no renderer can be held to anything."""

    color: np.ndarray
    t: np.ndarray
    normal: np.ndarray
    objects: tuple[np.ndarray, ...]  # what perturbed rays of the pixel and its neighbours meet
    decided: np.ndarray

    def allows(self, index: np.ndarray) -> np.ndarray:
        """Where one of the 3 x 3 pixels around may see object `index`. (h, w)"""
        return np.logical_or.reduce([met == index for met in self.objects])


@lru_cache(maxsize=64)
def bounds(scene: Scene, accuracy: Accuracy) -> Bounds:
    """The bounds on `scene` of a renderer of `accuracy` against the reference's exact method."""
    made = Perturbations(scene, "exact")
    truth = made.picture(0.0, seed=0)
    response = {"color": np.zeros(truth.t.shape), "t": np.zeros(truth.t.shape), "normal": np.zeros(truth.t.shape)}
    objects = [truth.index]
    for seed in range(1, PROBES + 1):
        probe = made.picture(accuracy.unit, seed)
        same = (probe.index == truth.index) & (truth.index >= 0)
        objects.append(probe.index)
        with np.errstate(invalid="ignore"):
            for name, moved in (("color", np.abs(probe.color - truth.color).max(-1)),
                                ("t", np.where(same, np.abs(probe.t - truth.t), 0)),
                                ("normal", np.where(same, np.linalg.norm(probe.normal - truth.normal, axis=-1), 0))):
                response[name] = np.fmax(response[name], moved)
    widest = {name: SAFETY * dilation(plane, AROUND) for name, plane in response.items()}
    t = np.where(np.isfinite(truth.t), truth.t, 0)
    return Bounds(color=widest["color"] + accuracy.color * (1 + np.abs(truth.color).max(-1)),
                  t=widest["t"] + accuracy.depth * t, normal=widest["normal"] + accuracy.normal,
                  objects=tuple(_around(objects)), decided=~dilation(truth.status == UNDECIDED, AROUND))


def _around(planes: list[np.ndarray]):
    """The planes and all their shifts by a pixel, each different one once."""
    windows = (np.lib.stride_tricks.sliding_window_view(np.pad(plane, 1, mode="edge"), plane.shape) for plane in planes)
    shifted = (window[i, j] for window in windows for i in range(3) for j in range(3))
    return {plane.tobytes(): plane for plane in shifted}.values()
