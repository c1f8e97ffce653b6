"""Small scenes whose needs are known, and a search on one of them."""

import json
import time

from raytruth.comparisons.planning.search import Search, Yardstick, deciding
from raytruth.reference_tracer.scene.model import Scene

WIDTH, HEIGHT = 32, 24
FLOOR = {"name": "floor", "surface": {"type": "plane", "center": [0, -1, 0], "a": 0, "b": 1, "c": 0}}
BALL = {"name": "ball", "surface": {"type": "sphere", "center": [0, 0, 4], "r": 1}}


REFLECTION = 0.1  # of the mirrors
MIRRORS = [{"surface": {"type": "plane", "center": [0, 0, -2 * facing], "a": 0, "b": 0, "c": facing},
            "material": {"reflection": REFLECTION}} for facing in (-1, 1)]


def scene(*objects, lights=((0, 5, 0),), **tracing) -> Scene:
    return Scene.model_validate_json(json.dumps({
        "name": "small", "camera": {"width": WIDTH, "height": HEIGHT}, "objects": objects,
        "lights": [{"position": p} for p in lights], "tracing": tracing}))


def corridor() -> Scene:
    """Two mirrors, a light at the camera: generation k adds (1 - R) R^k to every pixel, nearly: all rays are steep."""
    written = scene(*MIRRORS, lights=[(0, 0, 0)])
    return written.model_copy(update={"camera": written.camera.model_copy(update={"fov": 1.0})})


def searching(written: Scene, tolerance: float = 1e-3, margin: float = 0.9) -> Search:
    pixels = deciding(written.hash, written.camera.height, written.camera.width)
    return Search(Yardstick(written, tolerance), written, pixels, margin * tolerance, time.monotonic() + 300)
