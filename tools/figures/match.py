"""How near the shipped scenes come to the figures that the author published, and which switch makes what difference."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from raytruth.reference_tracer.errors import InputError
from raytruth.reference_tracer.scene.model import SWITCHES, Camera, Scene, Tracing

from .classes import classes
from .pixels import levels

LEVEL = 1  # grey levels, in the worst channel
BARS = {**dict.fromkeys(range(1, 5), 99.98), **dict.fromkeys((5, 6, 8), 99.8), 7: 99.0, 9: 99.0, "reflection": 99.0,
        **dict.fromkeys(range(10, 17), 99.5), 17: 98.0, 18: 95.0, 19: 95.0}  # percent of pixels, of the figure's form
SEED = 1
ATTRIBUTED = 20_000  # pixels on which switches are compared


def key(scene: Scene) -> int | str:
    """The number of the scene's figure, or "reflection" for the one that has none."""
    word = scene.name.split("-")[1]
    return int(word) if word.isdigit() else word


def figure_file(folder: Path, scene: Scene) -> Path:
    """The scene's figure in the folder: figure-05-....png, or the one called reflection. Raises InputError."""
    found = sorted(folder.glob(f"*{key(scene)}.png" if isinstance(key(scene), str) else f"figure-{key(scene):02}-*.png"))
    if not found:
        raise InputError(f"{folder}: holds no PNG of {scene.figure}; it must be called like figure-05-sphere.png")
    return found[0]


def match(scene: Scene, picture: np.ndarray, most: int | None = None) -> dict:
    """The text's form `scene` and its figure's form against the published `picture` (h, w, 3): see `raytruth`'s report.

    At most `most` pixels are compared, chosen at random. Raises InputError for a picture of another size.
    """
    figure, camera = scene.figure_form(), scene.camera
    if picture.shape[:2] != (camera.height, camera.width):
        raise InputError(f"{scene.name}: its figure has {picture.shape[1]} x {picture.shape[0]} pixels, the scene "
                         f"{camera.width} x {camera.height}")
    whole, random = camera.width * camera.height, np.random.default_rng(SEED)
    pixels = np.arange(whole) if most is None or most >= whole else np.sort(random.choice(whole, most, replace=False))
    published = picture.reshape(-1, 3)
    shown = levels(figure, pixels)
    left = pixels[_apart(shown, published[pixels])]
    few = np.sort(random.permutation(len(pixels))[:ATTRIBUTED])
    some, before = pixels[few], shown[few]
    switches = _switched(figure, scene, some, before, published[some])
    return {
        "size": [camera.width, camera.height], "pixels": len(pixels), "bar": BARS[key(scene)],
        "figure_form": _shares(shown, published[pixels]), "rest": _percent(_apart(shown, published[pixels])),
        "switched_pixels": len(some), "switches": switches[:-1], "text_form": switches[-1],
        "left": {name: count for name, count in classes(figure, left).items() if count}}


def _apart(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    return np.abs(a.astype(np.int16) - b).max(axis=1) > LEVEL


def _percent(mask: np.ndarray) -> float:
    return round(100 * float(mask.mean()), 4)


def _shares(a: np.ndarray, b: np.ndarray) -> dict:
    """Percent of pixels within a grey level, and equal."""
    return {"within_1": _percent(~_apart(a, b)), "equal": _percent((a == b).all(axis=1))}


def _switched(figure: Scene, text: Scene, pixels, shown, published) -> list[dict]:
    """From the figure's form to the text's: each switch `alone`, and `in_turn` with those before it, with the percent of
    pixels that it changes by more than a level; how near the published figure that is. The last entry is the text's form:
    in turn, what it has less of samples and generations of rays than the figure."""
    steps, turned, first = [], figure, shown
    for name, (part, *fields) in SWITCHES.items():  # F6 has none: its pixels are a class of those left
        defaults = {field: type(getattr(figure, part)).model_fields[field].default for field in fields}
        if all(getattr(getattr(figure, part), field) == value for field, value in defaults.items()):
            continue
        alone, turned = (_with(scene, part, defaults) for scene in (figure, turned))
        seen = levels(turned, pixels)
        steps.append({"id": name, "alone": _percent(_apart(levels(alone, pixels) if alone != turned else seen, first)),
                      "in_turn": _percent(_apart(seen, shown)), **_shares(seen, published)})
        shown = seen
    seen = levels(text, pixels)
    return [*steps, {"in_turn": _percent(_apart(seen, shown)), **_shares(seen, published)}]


def _with(scene: Scene, part: str, changes: dict) -> Scene:
    kind = {"tracing": Tracing, "camera": Camera}[part]
    return scene.model_copy(update={part: kind.model_validate({**getattr(scene, part).model_dump(), **changes})})
