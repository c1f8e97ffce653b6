"""The camera of section 2 as a Mitsuba sensor."""

from __future__ import annotations

import numpy as np

from raytruth.reference_tracer.errors import UnsupportedError
from raytruth.reference_tracer.scene.model import Camera
from raytruth.reference_tracer.tracer.camera import canvas_point, frame

from .variant import mi


def sensor(camera: Camera, samples: int = 1) -> mi.Sensor:
    """A perspective sensor whose pixel centres look along the rays of section 2 (to fp32 accuracy).

    `samples` = n^2 a pixel lie in the centres of n x n cells (section 5). Raises UnsupportedError for axes of decision F5.
    """
    return mi.load_dict(sensor_parts(camera, samples))


def sensor_parts(camera: Camera, samples: int = 1) -> dict:
    """The same as the dictionary that Mitsuba makes a sensor of."""
    if camera.is_oblique:
        raise UnsupportedError("Mitsuba's cameras have axes at right angles, v_x to the right and v_y up; these (decision F5) "
                               "have not")
    f = frame(camera)
    to_world = mi.ScalarTransform4f().look_at(
        origin=f.v_pos.tolist(), target=(f.v_pos + f.v_dir).tolist(), up=f.v_y.tolist())
    return {
        "type": "perspective",
        "fov": camera.fov, "fov_axis": "larger",  # decision C1
        "to_world": to_world @ mi.ScalarTransform4f().scale([-1, 1, 1]),  # Mitsuba's x runs left
        "film": {"type": "hdrfilm", "width": camera.width, "height": camera.height, "rfilter": {"type": "box"},
                 "pixel_format": "rgb", "component_format": "float32"},
        "sampler": {"type": "stratified", "sample_count": samples, "jitter": False}}


def document_directions(camera: Camera, samples: int = 1, first: int = 0, count: int | None = None) -> np.ndarray:
    """(count * samples^2, 3) fp64: the unit directions of section 2 for pixels in row order, n x n a pixel."""
    f = frame(camera)
    count = camera.width * camera.height - first if count is None else count
    lane = np.arange(count * samples**2)
    row, column = np.divmod(first + lane // samples**2, f.width)
    sample = lane % samples**2
    x, y = canvas_point(f, row, column, sample // samples, sample % samples, samples)
    d = x[:, None] * f.v_x + y[:, None] * f.v_y + f.v_dir
    return d / np.linalg.norm(d, axis=1, keepdims=True)


def pixel_directions(of: mi.Sensor) -> np.ndarray:
    """(height, width, 3) fp32: the unit directions of the rays that `of` sends through the pixels' centres."""
    width, height = of.film().size()
    row, column = np.divmod(np.arange(width * height), width)
    position = mi.Point2f(mi.Float(((column + 0.5) / width).astype(np.float32)),
                          mi.Float(((row + 0.5) / height).astype(np.float32)))
    ray, _ = of.sample_ray(mi.Float(0), mi.Float(0), position, mi.Point2f(0.5))
    return ray.d.numpy().T.reshape(height, width, 3)
