"""A scene as plain text for ports of the document: one line a thing, a word and numbers, nothing to parse.

    camera      position(3) direction(3) up(3) fov width height
    axes        v_x(3) v_y(3)
    tracing     step_size tolerance max_iterations max_distance max_depth samples
    figures     lights ambient shadows range
    background  colour(3)
    light       position(3) brightness(3)
    object      colour(3) reflection transparency refractive_index  center(3) axis(3) degrees sign  kind parameters
    shadowless  number of an object
    misprint

`sign` is -1 where f > 0 is inside; `degrees` 0 means no rotation. Most scenes lack the lines `axes`, of a camera whose
axes do not follow from `up` (decision F5), `figures`, the words of decisions F1 to F4 as in a scene file where one is not
"sum", 0, "attenuate" or "ray", `shadowless`, an object (counted from 0) that dims no light, and `misprint`, of refraction as
printed (decision E1). Numbers have as many digits as it takes to read them back exactly. `raytruth export
SCENE -o FILE.txt` writes one.
"""

from __future__ import annotations

from raytruth.reference_tracer.errors import UnsupportedError
from raytruth.reference_tracer.scene.model import EFFECTS, Object, Scene, Tracing

FIGURES = ("lights", "ambient", "shadows", "range")
KINDS = ("plane", "sphere", "ellipsoid", "torus", "paraboloid", "heart")


def plain(scene: Scene) -> str:
    """The text of `scene`. Raises UnsupportedError where a scene asks for more than the document has."""
    _require_the_documents_own(scene)
    camera, tracing = scene.camera, scene.tracing
    lines = [
        _line("camera", *camera.position, *camera.direction, *camera.up, camera.fov, camera.width, camera.height),
        *([_line("axes", *camera.axes[1], *camera.axes[2])] if camera.v_x or camera.v_y else []),
        _line("tracing", tracing.step_size, tracing.tolerance, tracing.max_iterations, tracing.max_distance,
              tracing.max_depth, tracing.samples),
        *([_line("figures", *(getattr(tracing, name) for name in FIGURES))] if _follows_figures(tracing) else []),
        _line("background", *scene.background),
        *(_line("light", *light.position, *light.brightness) for light in scene.lights),
        *(_object(obj) for obj in scene.objects),
        *(_line("shadowless", k) for k, obj in enumerate(scene.objects) if not obj.shadow),
        *(["misprint"] if tracing.refraction == "as_printed" else [])]
    return "\n".join(lines) + "\n"


def _line(*words) -> str:
    return " ".join(map(str, words))


def _follows_figures(tracing: Tracing) -> bool:
    return any(getattr(tracing, name) != getattr(Tracing(), name) for name in FIGURES)


def _object(obj: Object) -> str:
    m, surface = obj.material, obj.surface
    axis, degrees = (obj.rotation.axis, obj.rotation.degrees) if obj.rotation else ((0, 0, 1), 0)
    sign = -1 if surface.inside == "positive" else 1
    return _line("object", *m.color, m.reflection, m.transparency, m.refractive_index,
                 *surface.center, *axis, degrees, sign, surface.type, *surface.parameters.values())


def _require_the_documents_own(scene: Scene) -> None:
    plain_tracing, own = Tracing(), ("effects", "cutoff", "adaptive", "precision")
    changed = [name for name in own if getattr(scene.tracing, name) != getattr(plain_tracing, name)]
    if set(scene.tracing.effects) == set(EFFECTS) and "effects" in changed:
        changed.remove("effects")
    if changed:
        raise UnsupportedError(f"{scene.name}: a plain scene has no tracing.{changed[0]}")
    for obj in scene.objects:
        if obj.surface.type not in KINDS:
            raise UnsupportedError(f"{scene.name}: a plain scene has no surface of type {obj.surface.type}")
        if obj.first_hit:
            raise UnsupportedError(f"{scene.name}: a plain scene has one first-hit method for all objects")
