"""Which transparent objects lie within others, and the refractive indices that make POV-Ray follow decision R1.

POV-Ray refracts between an object and what surrounds it, the document between an object and air, always. Entering an
object of index n from a surrounding one of index m, POV-Ray takes the ratio m / n', the document 1 / n: they agree for
n' = m n, on the way out too. That needs one object to lie wholly within the other. Interval arithmetic proves it, or
that the two are apart; where it proves neither, the scene is refused.
"""

from __future__ import annotations

import numpy as np

from raytruth.converters.mesh.placed import Placed
from raytruth.reference_tracer.errors import UnsupportedError
from raytruth.reference_tracer.scene.model import Object, Scene
from raytruth.reference_tracer.scene.placement import corners, is_inside, reach

from .cells import enclosed, holds_everywhere
from .distance import bounds


def refractive_indices(scene: Scene) -> list[float]:
    """For every object the index that POV-Ray needs. Raises UnsupportedError where objects may overlap."""
    indices = [o.material.refractive_index for o in scene.objects]
    clear = [k for k, o in enumerate(scene.objects) if o.material.transparency > 0]
    holds = {}  # for every object, the objects around it
    for a in clear:
        for b in clear:
            if a < b and (indices[a] != 1 or indices[b] != 1):
                match _relation(scene, scene.objects[a], scene.objects[b]):
                    case "within":
                        holds.setdefault(a, []).append(b)
                    case "around":
                        holds.setdefault(b, []).append(a)
                    case "unknown":
                        raise UnsupportedError(
                            f"{_name(scene, a)} and {_name(scene, b)} are transparent and may overlap; POV-Ray would refract "
                            "between the two, the document always refracts between one and air")
    around_camera = [k for k in clear if is_inside(scene.objects[k], scene.camera.position)]
    if len(around_camera) > 1 and any(indices[k] != 1 for k in around_camera):
        raise UnsupportedError("the camera is within two transparent objects, whose order POV-Ray does not know")
    return _single_precision(indices, holds)


def _single_precision(indices: list[float], holds: dict[int, list[int]]) -> list[float]:
    """The products of the indices of nested objects, as POV-Ray keeps them: in fp32.

    Where two media would be equal, POV-Ray does not count the ray between them as one of the next generation (D1): a
    last digit more makes it do so.
    """
    depth = lambda k: len(holds.get(k, ()))
    found = {}
    for k in sorted(range(len(indices)), key=depth):
        outside = found[max(holds[k], key=depth)] if k in holds else np.float32(1)
        own = np.float32(outside * indices[k])
        found[k] = own if own != outside else np.nextafter(own, np.float32(np.inf))
    return [float(found[k]) for k in range(len(indices))]


def _name(scene: Scene, k: int) -> str:
    return scene.objects[k].name or f"{scene.objects[k].surface.type} {k + 1}"


def _relation(scene: Scene, a: Object, b: Object) -> str:
    """"apart", "within" (a in b), "around" (b in a), or "unknown" where no proof was found."""
    first, second = (a, b) if _is_compact(a) or not _is_compact(b) else (b, a)
    outside = lambda obj: lambda cells: enclosed(obj, cells)[0] >= 0
    inside = lambda obj: lambda cells: enclosed(obj, cells)[1] < 0
    here = _domain(scene, first)
    if holds_everywhere(here, outside(first), outside(second)):
        return "apart"
    if holds_everywhere(here, outside(first), inside(second)):
        return "within" if first is a else "around"
    if holds_everywhere(_domain(scene, second), outside(second), inside(first)):
        return "around" if first is a else "within"
    return "unknown"


def _is_compact(obj: Object) -> bool:
    return obj.surface.box() is not None


def _domain(scene: Scene, obj: Object) -> np.ndarray:
    """(2, 3): a box in world space that holds all of the solid that rays can visit."""
    points = Placed(obj).corners_in_world() if _is_compact(obj) else corners(reach(scene))
    return bounds(points)
