"""Pictures as lists of pixels: chosen pixels of a scene rendered, and pictures of other programs read."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from raytruth.reference_tracer.errors import InputError
from raytruth.reference_tracer.scene.model import Scene
from raytruth.reference_tracer.tracer.camera_rays import camera_rays
from raytruth.reference_tracer.tracer.image_files import to_8_bit
from raytruth.reference_tracer.tracer.render import Renderer
from raytruth.reference_tracer.tracer.wavefront import MOST_RAYS

METHOD = "paper"  # the published figures were made by the document's own method


def colors(scene: Scene, pixels: np.ndarray, recorded: Renderer | None = None) -> np.ndarray:
    """The linear colours (n, 3) of the `pixels`, numbers in row order, with the scene's own samples.

    `recorded` is a renderer of a scene that differs in numbers only, no number of which is zero in one of the two and not in
    the other: its kernels are replayed, which takes a fifth of the time of recording them for a few thousand rays.
    """
    renderer, samples = recorded or Renderer(scene, METHOD), scene.tracing.samples
    if recorded:
        renderer.show(scene)
    found, world = np.empty((len(pixels), 3)), renderer.world
    most = max(1, MOST_RAYS // samples**2)
    for start in range(0, len(pixels), most):
        part = pixels[start:start + most]
        light, _ = renderer.wavefront.trace(camera_rays(world, part, samples), len(part) * samples**2,
                                            max(len(part), 2), primary=False)
        found[start:start + most] = renderer.developed(light, None, samples)["color"].numpy()[:, :len(part)].T
    return found


def levels(scene: Scene, pixels: np.ndarray | None = None) -> np.ndarray:
    """The 8-bit grey levels (n, 3) of the `pixels`, or of all (h, w, 3) (decision P1)."""
    camera = scene.camera
    if pixels is not None:
        return to_8_bit(colors(scene, pixels))
    return to_8_bit(colors(scene, np.arange(camera.width * camera.height))).reshape(camera.height, camera.width, 3)


def read_picture(path: Path) -> np.ndarray:
    """The 8-bit grey levels (h, w, 3) of a picture file. Raises InputError."""
    import OpenImageIO as oiio

    source = oiio.ImageInput.open(str(path))
    if source is None:
        oiio.geterror()  # else it is printed at exit
        raise InputError(f"{path}: is not a picture that can be read; give a PNG file")
    try:
        spec = source.spec()
        if spec.nchannels < 3 or not 0 < spec.width * spec.height <= 1 << 26:
            raise InputError(f"{path}: must have three channels and at most {1 << 26} pixels")
        found = source.read_image("uint8")
    finally:
        source.close()
    if found is None:
        raise InputError(f"{path}: is damaged; save it again")
    return np.asarray(found)[..., :3]
