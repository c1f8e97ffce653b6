"""A whole scene as POV-Ray's scene description language (SDL)."""

from __future__ import annotations

import re
from dataclasses import dataclass, replace

import numpy as np

from raytruth.converters.mesh.occupied import tight_box
from raytruth.converters.mesh.placed import Placed
from raytruth.reference_tracer.errors import InputError, UnsupportedError
from raytruth.reference_tracer.scene.model import Object, Scene
from raytruth.reference_tracer.scene.placement import is_inside, reach_in_frame
from raytruth.reference_tracer.tracer.camera import frame

from . import materials, passes, shapes
from .distance import END, far_shadows, origins, within_distance
from .gradient import max_gradient
from .media import refractive_indices
from .text import declared
from .words import number, vector

SHAPES = ("native", "isosurface")
SHOWN = ("color", "share", "object", "distance", "normal")
FLAT = 1e-3  # of a container's longest side: what its others have at least on either side of the surface
ACCURACY = 1e-8  # of isosurfaces, in the scene's unit; a tighter one gains nothing

HEAD = """#version 3.7;
global_settings {{ assumed_gamma 1.0 ambient_light rgb 1 adc_bailout 0 max_trace_level {level} }}
#default {{ finish {{ ambient 0 emission 0 diffuse 0 brilliance 1 phong 0 specular 0 reflection 0 }} }}"""


@dataclass(frozen=True)
class Conversion:
    """A scene bound to its conversion: `text` writes it, as often as asked, with whatever is to be shown."""

    scene: Scene
    brightest: float  # lights and background are divided by it, because POV-Ray's pictures end at 1
    indices: list[float]  # the refractive indices that POV-Ray needs
    containers: dict[int, np.ndarray]  # (2, 3) for every object that is an isosurface, in its own frame
    gradients: dict[int, float]  # its max_gradient
    proven: frozenset[int]  # those whose max_gradient is one for sure
    accuracy: float
    only_camera: bool  # whether no rays but the camera's look for hits
    remark: str  # what is not proven to be expressed, in a few words; "" if nothing
    needs_share: bool  # whether the background has to be added to the picture: 1 - share of it

    @property
    def scale(self) -> float:
        return END / self.scene.tracing.max_distance

    def text(self, shown: str = "color") -> str:
        """The scene in SDL. `shown` is one of SHOWN; "share" is the weight of objects' own colours in a pixel."""
        if shown not in SHOWN:
            raise InputError(f"POV-Ray can be made to show one of {', '.join(SHOWN)}; found {shown!r}")
        through = shown in ("color", "share")
        lines = [HEAD.format(level=self.scene.tracing.max_depth + 1 if through else 1), declared(), self._camera(),
                 self._background(shown)]
        if shown == "distance":
            lines.append(passes.declare_distance(self.scale * np.array(self.scene.camera.position), END))
        if shown == "color":
            lines += self._lights()
        for k, obj in enumerate(self.scene.objects):
            lines += [f"{shape} {dress} }} // object {k}" for shape, dress in self._parts(k, obj, shown)]
        return "\n".join(lines) + "\n"

    def with_gradients(self, gradients: dict[int, float]) -> Conversion:
        """The same with other values of max_gradient for some objects."""
        return replace(self, gradients={**self.gradients, **gradients})

    def _camera(self) -> str:
        f = frame(self.scene.camera)  # POV-Ray's rays go through the middles of pixels too, whatever the aspect
        return (f"camera {{ perspective location {vector(self.scale * f.v_pos)} right {vector(f.v_x * f.ratio * f.width)} "
                f"up {vector(f.v_y * f.ratio * f.height)} direction {vector(f.v_dir)} }}")

    def _background(self, shown: str) -> str:
        color = np.array(self.scene.background) / self.brightest
        return f"background {{ rgb {vector(color if shown == 'color' and not self.needs_share else [0, 0, 0])} }}"

    def _lights(self) -> list[str]:
        shadowless = "" if "shadow" in self.scene.tracing.effects else " shadowless"
        return [f"light_source {{ {vector(self.scale * np.array(light.position))} "
                f"rgb {vector(np.array(light.brightness) / self.brightest)}{shadowless} }}" for light in self.scene.lights]

    def _parts(self, k: int, obj: Object, shown: str) -> list[tuple[str, str]]:
        """The shapes and materials that stand for object `k`; a part that casts no shadow has a twin that does."""
        shape, seen = self._shapes(k, obj, shown in ("color", "share"))
        if shape is None:
            return []
        # a twin that holds the camera would be taken for a medium around it
        shadow = f"{shape} inverse" if is_inside(obj, self.scene.camera.position) else shape
        match shown:
            case "object":
                return [(seen, passes.object_number(k))]
            case "distance":
                return [(seen, passes.DISTANCE)]
            case "normal":
                return [(seen, passes.NORMAL)]
        own, m = materials.LIT if shown == "color" else materials.GLOWING, obj.material
        ambient, casts_shadow = self.scene.tracing.ambient / self.brightest, self.scene.casts_shadow(obj)
        twin = [(shadow, materials.twin(m))] if casts_shadow else []
        if m.transparency:
            return [(seen, materials.body(m, self.indices[k], own, ambient)), *twin]
        dress = materials.opaque(m, own, ambient)
        if self._is_clipped(k):
            return [(seen, f"{dress} no_shadow"), *twin]
        return [(seen, dress if casts_shadow else f"{dress} no_shadow")]

    def _shapes(self, k: int, obj: Object, with_secondary_rays: bool) -> tuple[str | None, str | None]:
        """The whole shape of object `k`, and what rays that look for a hit may see of it; None where that is nothing."""
        if k not in self.containers:
            whole = shapes.native(obj, self.scale)
            return whole, whole
        if self.containers[k] is None:
            return None, None
        clipped = self._is_clipped(k)
        whole = shapes.isosurface(obj, self.scale, self.containers[k], self.accuracy, self.gradients[k],
                                  every_root=clipped or with_secondary_rays)
        eye = vector(self.scale * np.array(self.scene.camera.position))
        return whole, f"{whole} clipped_by {{ sphere {{ {eye}, {number(END)} }} }}" if clipped else whole

    def _is_clipped(self, k: int) -> bool:
        """Whether object `k` is an isosurface to be cut where the camera's rays end: then there are no other rays."""
        return k in self.containers and self.only_camera and not within_distance(self.scene, self.scene.objects[k])


def object_of(line: str) -> int | None:
    """The object, in scene order, that a line of the text is about."""
    found = re.search(r"// object (\d+)$", line)
    return int(found[1]) if found else None


def convert(scene: Scene, shapes: str = "native", accuracy: float = ACCURACY) -> Conversion:
    """`scene` for POV-Ray. Raises UnsupportedError, with the reason, where POV-Ray cannot show what the document says.

    `shapes` "native" takes POV-Ray's own primitives and isosurfaces for the rest, "isosurface" takes isosurfaces only;
    they are found to `accuracy`, in the scene's unit of length.
    """
    if shapes not in SHAPES:
        raise InputError(f"shapes must be one of {', '.join(SHAPES)}; found {shapes!r}")
    if not 1e-12 <= accuracy <= 1:
        raise InputError(f"the accuracy of isosurfaces must lie between 1e-12 and 1; found {accuracy}")
    _require_expressible(scene)
    scene = scene.model_copy(update={"objects": tuple(map(_outward, scene.objects))})
    starts = origins(scene)
    from_camera_only = starts is not None and bool(np.all(starts[0] == starts[1]))
    as_isosurface = []
    for k, obj in enumerate(scene.objects):
        bounded = obj.surface.region() is not None
        if shapes == "native" or not (bounded or from_camera_only):  # beyond max_distance only native ones end
            if _has_native(obj):
                continue
            if not (bounded or from_camera_only):
                raise UnsupportedError(f"{_name(obj)} is an unbounded isosurface, which POV-Ray cannot end at max_distance "
                                       "for reflected and refracted rays; give it bounds")
        as_isosurface.append(k)
    containers = {k: _container(scene, scene.objects[k]) for k in as_isosurface}
    gradients = {k: max_gradient(Placed(scene.objects[k]), box) for k, box in containers.items() if box is not None}
    proven = frozenset(k for k, (_, is_proof) in gradients.items() if is_proof)
    brightest = max(*(scene.tracing.ambient + sum(light.brightness[c] for light in scene.lights) for c in range(3)),
                    *scene.background) or 1.0
    goes_on = any(o.material.reflection or o.material.transparency for o in scene.objects)
    remarks = [far_shadows(scene), *(f"{_name(scene.objects[k])}: {told}" for k in as_isosurface
                                     if (told := Placed(scene.objects[k]).unproven))]
    if not from_camera_only:
        remarks += [f"{_name(scene.objects[k])} may be seen from farther than max_distance" for k in as_isosurface
                    if not within_distance(scene, scene.objects[k])]
    return Conversion(scene, brightest, refractive_indices(scene), containers,
                      {k: value for k, (value, _) in gradients.items()}, proven, accuracy,
                      only_camera=from_camera_only, remark="; ".join(filter(None, remarks)),
                      needs_share=goes_on and any(scene.background))


def scene_text(scene: Scene, shown: str = "color", **options) -> str:
    """`scene` in SDL; for the options see `convert`, for `shown` see `Conversion.text`."""
    return convert(scene, **options).text(shown)


def _outward(obj: Object) -> Object:
    """The same object with its inside where f is negative: glass around a hollow is a ball of index 1 / n in the hollow."""
    if obj.surface.inside == "negative":
        return obj
    index = 1 / obj.material.refractive_index
    return obj.model_copy(update={"surface": obj.surface.model_copy(update={"inside": "negative"}),
                                  "material": obj.material.model_copy(update={"refractive_index": index})})


def _name(obj: Object) -> str:
    return obj.name or obj.surface.type


def _has_native(obj: Object) -> bool:
    return shapes.native(obj, 1.0) is not None


def _container(scene: Scene, obj: Object) -> np.ndarray | None:
    """(2, 3): a box in the object's own frame that holds what rays can meet of it; None where that is nothing."""
    placed = Placed(obj)
    own = shapes.own_container(placed)
    if own is not None:
        return own
    tight = tight_box(placed, reach_in_frame(scene, obj))
    # a flat surface fits a box without any thickness, in which no root can be bracketed
    return None if tight is None else tight + FLAT * np.max(tight[1] - tight[0]) * np.array([[-1], [1]])


def _require_expressible(scene: Scene) -> None:
    tracing = scene.tracing
    if tracing.refraction != "snell":
        raise UnsupportedError("POV-Ray refracts by Snell's law; the misprinted formula (decision E1) cannot be expressed")
    if tracing.lights != "sum":
        raise UnsupportedError("POV-Ray adds lights; their balanced combination (decision F1) cannot be expressed")
    if tracing.range != "ray":
        raise UnsupportedError("POV-Ray ends all rays at one distance; a range shared along a path (decision F4) cannot be "
                               "expressed")
    for name in ("cutoff", "adaptive"):
        if getattr(tracing, name):
            raise UnsupportedError(f"POV-Ray has no counterpart of {name}; set it to 0")
    if missing := {"reflection", "refraction"} - set(tracing.effects):
        raise UnsupportedError(f"POV-Ray cannot leave out {' and '.join(sorted(missing))} rays as the document's tracer does")
