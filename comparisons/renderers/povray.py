"""POV-Ray 3.7 on a scene: an oracle of the whole model, from the camera to the mixing of colours, that shares no code.

The picture has 16 bits a channel: its colours are off by up to half a step, 7.7e-6 of the brightest possible one.
"""

from __future__ import annotations

import time

import numpy as np

from raytruth.converters.povray import Conversion, convert, object_of, passes
from raytruth.reference_tracer.scene.model import Scene
from raytruth.reference_tracer.tracer.camera import canvas_point, frame
from raytruth.reference_tracer.tracer.render import HIT, MISS, Picture

from .povray_process import SECONDS, Shot, run

MOST_TRIES = 4  # pictures made for the sake of max_gradient
SPARE = 1.3  # over the gradient that POV-Ray says it has found


def render(scene: Scene, *, shapes: str = "native", accuracy: float = 1e-8, planes: bool = True,
           threads: int | None = None, seconds: float = SECONDS) -> Picture:
    """The picture of `scene` by POV-Ray.

    Its metadata tells the seconds of the process (`first`) and of the processor while tracing (`cpu`). Without
    `planes` only colours are made, and the geometry planes say that nothing was hit. POV-Ray does not tell how deep
    it traced: the plane of depths is 0. Raises UnsupportedError with the reason where POV-Ray cannot express the
    scene, MissingError without POV-Ray, and PovrayError where it fails.
    """
    start = time.perf_counter()
    converted = convert(scene, shapes, accuracy)
    build = time.perf_counter() - start
    shoot = _Shooting(converted, threads, seconds)
    picture, facts = shoot.color()
    camera = scene.camera
    geometry = shoot.geometry() if planes else _nothing(camera.height, camera.width)
    status = np.where(geometry["index"] >= 0, HIT, MISS).astype(np.uint8)
    depth = np.zeros((camera.height, camera.width), np.uint8)
    metadata = {"scene": scene.name, "scene_hash": scene.hash, "renderer": "povray", "shapes": shapes,
                "accuracy": accuracy, "isosurfaces": len(converted.containers), "brightest": converted.brightest,
                "precision": _precision(converted), "not proven": converted.remark, "tells_depth": False,
                "build": build, "warm": None, **facts}
    return Picture(color=picture, depth=depth, status=status, scene=scene, metadata=metadata, **geometry)


def _precision(converted: Conversion) -> int:
    """The bits of the numbers that rays go by: indices of refraction are fp32, and isosurfaces not much better."""
    bent = any(o.material.transparency for o in converted.scene.objects)
    return 32 if bent or converted.containers else 64


class _Shooting:
    """The pictures that POV-Ray has to make of one scene."""

    def __init__(self, converted: Conversion, threads: int | None, seconds: float):
        self.converted, self.scene, self.threads = converted, converted.scene, threads
        self.deadline = time.monotonic() + seconds

    def _shot(self, shown: str, samples: int = 1) -> Shot:
        camera = self.scene.camera
        return run(self.converted.text(shown), samples * camera.width, samples * camera.height, threads=self.threads,
                   seconds=max(self.deadline - time.monotonic(), 1.0))

    def color(self) -> tuple[np.ndarray, dict]:
        """(h, w, 3) colours and what is to be told about them."""
        samples = self.scene.tracing.samples
        for tries in range(1, MOST_TRIES + 1):
            shot = self._shot("color", samples)
            steep = self._steep(shot)
            if not steep:
                break
            if tries < MOST_TRIES:
                self.converted = self.converted.with_gradients({k: SPARE * found for k, found in steep.items()})
        color = self.converted.brightest * _mean(shot.pixels, samples)
        if self.converted.needs_share:
            # beyond the last generation POV-Ray sees black, the document the background (D1): what does not end on an
            # object ends there
            color = color + (1 - _mean(self._shot("share", samples).pixels, samples)) * np.array(self.scene.background)
        return color, {"povray": shot.version, "first": shot.seconds, "cpu": shot.cpu, "pictures": tries,
                       "holes": "; ".join(f"object {k}: gradient {found:g} found" for k, found in steep.items())}

    def _steep(self, shot: Shot) -> dict[int, float]:
        """Objects whose max_gradient may be too small, and the gradient found; what is proven needs no confirmation."""
        lines = self.converted.text("color").splitlines()
        found: dict[int, float] = {}
        for line, gradient in shot.steep.items():
            k = object_of(lines[line - 1]) if line <= len(lines) else None
            if k is not None and k not in self.converted.proven:
                found[k] = max(gradient, found.get(k, 0.0))
        return found

    def geometry(self) -> dict[str, np.ndarray]:
        """The planes of the ray through each pixel's centre, from what POV-Ray shows of objects, distances, normals."""
        index = passes.numbers_of(self._shot("object").pixels)
        met = index >= 0
        t = passes.distances_of(self._shot("distance").pixels, self.scene.tracing.max_distance)
        normal = passes.normals_of(self._shot("normal").pixels)
        d = _directions(self.scene)
        normal = np.where(np.sum(d * normal, axis=-1, keepdims=True) > 0, -normal, normal)
        t = np.where(met, t, np.inf)
        position = np.array(self.scene.camera.position) + np.where(met, t, np.nan)[..., None] * d
        return {"index": index, "t": t, "position": position, "normal": np.where(met[..., None], normal, np.nan)}


def _mean(pixels: np.ndarray, samples: int) -> np.ndarray:
    """(h, w, 3) fp64 in [0, 1]: the plain mean of n x n samples (decision C2)."""
    h, w, _ = pixels.shape
    return pixels.reshape(h // samples, samples, w // samples, samples, 3).mean(axis=(1, 3), dtype=float) / passes.STEPS


def _directions(scene: Scene) -> np.ndarray:
    """(h, w, 3): the unit directions of section 2."""
    f = frame(scene.camera)
    row, col = np.mgrid[:scene.camera.height, :scene.camera.width]
    x, y = canvas_point(f, row, col, 0, 0, 1)
    d = x[..., None] * f.v_x + y[..., None] * f.v_y + f.v_dir
    return d / np.linalg.norm(d, axis=-1, keepdims=True)


def _nothing(height: int, width: int) -> dict[str, np.ndarray]:
    unknown = np.full((height, width, 3), np.nan)
    return {"index": np.full((height, width), -1, np.int32), "t": np.full((height, width), np.inf),
            "position": unknown, "normal": unknown.copy()}
