"""The scene format: what a scene file may say. The published JSON Schema is generated from these classes."""

from __future__ import annotations

import hashlib
import json
import math
from typing import Annotated, Literal

from pydantic import BaseModel, ConfigDict, Field, JsonValue, model_serializer, model_validator

from ..errors import InputError
from ..surfaces import AnySurface
from ..surfaces.surface import Finite, Length, Vector
from .promises import broken

MOST_OBJECTS = 1024
MOST_LIGHTS = 64
LONGEST_SIDE = 16384  # pixels
MOST_PIXELS = 2**26
MOST_STEPS = 1_000_000
SLIVER = 1e-12  # of max_distance: a rest of a path's range as short as that is rounding, and none (decision F4)
AS_PUBLISHED = "-as-published"  # behind the name of a scene that is taken as its figure shows it


Fraction = Annotated[float, Field(ge=0, le=1)]
Intensity = Annotated[float, Field(ge=0, le=1000)]
Colour = tuple[Fraction, Fraction, Fraction]
ShortText = Annotated[str, Field(max_length=200)]
StepSize = Annotated[float, Field(ge=1e-6, le=1000)]
Effect = Literal["shadow", "reflection", "refraction"]
SWITCHES = {"E1": ("tracing", "refraction"), "F1": ("tracing", "lights"), "F2": ("tracing", "ambient"),
            "F3": ("tracing", "shadows"), "F4": ("tracing", "range"), "F5": ("camera", "v_x", "v_y")}
EFFECTS: tuple[Effect, ...] = ("shadow", "reflection", "refraction")


class Part(BaseModel):
    """Base of everything in a scene: immutable, strictly typed, no unknown keys, no NaN."""

    model_config = ConfigDict(frozen=True, extra="forbid", strict=True, allow_inf_nan=False)


def _length(v) -> float:
    return math.sqrt(sum(c * c for c in v))


def _cross(v, w):
    return v[1] * w[2] - v[2] * w[1], v[2] * w[0] - v[0] * w[2], v[0] * w[1] - v[1] * w[0]


def _volume(u, v, w) -> float:
    return sum(a * b for a, b in zip(u, _cross(v, w)))


def _unit(v):
    length = _length(v)
    return tuple(c / length for c in v)


def _require_direction(v, what: str):
    if _length(v) < 1e-6:
        raise ValueError(f"{what} must not be the zero vector")


class Camera(Part):
    """Section 2: a canvas at distance 1 in front of `position`; decisions C1 and F5 fix the axes."""

    position: Vector = (0.0, 0.0, 0.0)
    direction: Vector = Field(default=(0.0, 0.0, 1.0), description="where the camera looks; any length but zero")
    up: Vector = Field(default=(0.0, 1.0, 0.0), description="the side of the picture's top; not parallel to direction")
    v_x: Vector | None = Field(default=None, description="decision F5: the canvas's axis to the right, any length but "
                                                         "zero; made from up, at right angles to direction, if not given")
    v_y: Vector | None = Field(default=None, description="decision F5: the canvas's axis to the top; at right angles to "
                                                         "direction and v_x if not given")
    fov: Annotated[float, Field(gt=0, lt=180)] = Field(default=60.0, description="field of view over the longer side, degrees")
    width: Annotated[int, Field(ge=1, le=LONGEST_SIDE)] = 640
    height: Annotated[int, Field(ge=1, le=LONGEST_SIDE)] = 480

    @model_validator(mode="after")
    def _is_a_frame(self):
        _require_direction(self.direction, "direction")
        _require_direction(self.up, "up")
        if self.v_x is None and _length(_cross(self.direction, self.up)) < 1e-6 * _length(self.direction) * _length(self.up):
            raise ValueError("up must not be parallel to direction")
        for name in ("v_x", "v_y"):
            if (axis := getattr(self, name)) is not None:
                _require_direction(axis, name)
        along = self.v_x and _length(_cross(_unit(self.direction), _unit(self.v_x))) < 1e-6  # v_y cannot be made of the two
        if along or ((self.v_x or self.v_y) and abs(_volume(*self.axes)) < 1e-6):
            raise ValueError("direction, v_x and v_y must not lie in a plane")
        if self.width * self.height > MOST_PIXELS:
            raise ValueError(f"width * height must be at most {MOST_PIXELS} pixels")
        return self


    @property
    def axes(self) -> tuple[Vector, Vector, Vector]:
        """The unit vectors v_dir, v_x and v_y (section 2; decisions C1, F5), in fp64."""
        v_dir = _unit(self.direction)
        v_x = _unit(self.v_x or _cross(self.up, v_dir))
        return v_dir, v_x, _unit(self.v_y) if self.v_y else _unit(_cross(v_dir, v_x))

    @property
    def is_oblique(self) -> bool:
        """Whether the axes that are given are not at right angles, or left-handed, beyond rounding (decision F5)."""
        return abs(_volume(*self.axes) - 1) > 1e-12 if self.v_x or self.v_y else False


class Rotation(Part):
    """A turn about an axis through the surface's centre (decision O3), by Rodrigues' formula."""

    axis: Vector
    degrees: Finite

    @model_validator(mode="after")
    def _has_an_axis(self):
        _require_direction(self.axis, "axis")
        return self


class Material(Part):
    """Section 3: how an object answers light."""

    color: Colour = (1.0, 1.0, 1.0)
    reflection: Fraction = 0.0
    transparency: Fraction = 0.0
    refractive_index: Annotated[float, Field(ge=0.1, le=10)] = 1.0


class FirstHitChoice(Part):
    """How the first hits of one object are found, whatever method the picture is rendered with."""

    method: Literal["paper", "exact", "descartes", "interval"]
    step_size: StepSize | None = Field(default=None, description="of the method paper; the scene's if not given")


class Object(Part):
    """A surface with its place and its material."""

    name: ShortText = ""
    surface: AnySurface
    rotation: Rotation | None = None
    material: Material = Material()
    first_hit: FirstHitChoice | None = Field(default=None, description="a method for this object alone")
    shadow: bool = Field(default=True, description="whether it dims the light that crosses it")


class Light(Part):
    """A point light; its brightness does not fall off with distance (decision L1)."""

    position: Vector
    brightness: tuple[Intensity, Intensity, Intensity] = (1.0, 1.0, 1.0)


class Tracing(Part):
    """The parameters of sections 4 and 5."""

    step_size: StepSize = Field(default=0.1, description="stepSize of section 4.1")
    tolerance: Annotated[float, Field(ge=1e-15, le=1)] = Field(
        default=1e-12, description="Newton stops at |dt| <= tolerance max(1, |t|)")
    max_iterations: Annotated[int, Field(ge=1, le=1000)] = 20
    max_distance: Length = Field(default=30.0, description="where a ray ends")
    max_depth: Annotated[int, Field(ge=0, le=64)] = Field(default=8, description="generations of secondary rays")
    samples: Annotated[int, Field(ge=1, le=32)] = Field(default=1, description="n of n x n samples per pixel (section 5)")
    refraction: Literal["snell", "as_printed"] = Field(
        default="snell", description="decision E1: the law of refraction, or the misprinted formula of section 4.3.3.2")
    # where the document's figures do otherwise than its text
    lights: Literal["sum", "balanced"] = Field(
        default="sum", description="decision F1: how several lights add up; balanced: 1 - product of (1 - light), per channel")
    ambient: Intensity = Field(
        default=0.0, description="decision F2: a light that is never shadowed, the first of the combination")
    shadows: Literal["attenuate", "opaque_only"] = Field(
        default="attenuate", description="decision F3: what objects with transparency > 0 do to light; opaque_only: nothing")
    range: Literal["ray", "path"] = Field(
        default="ray", description="decision F4: whether each ray has max_distance of its own, or what its parent left of it")
    # what a scene needs no more of: see `raytruth plan`
    effects: Annotated[tuple[Effect, ...], Field(max_length=len(EFFECTS))] = Field(
        default=EFFECTS, description="the secondary rays that are traced; one left out sees the background, a shadow ray its "
                                     "light")
    cutoff: Annotated[float, Field(ge=0, le=1)] = Field(
        default=0.0, description="the most that all secondary rays left out for their small weight may change of a colour")
    adaptive: Annotated[float, Field(ge=0, le=1)] = Field(
        default=0.0, description="more than one sample only where the colour differs from a neighbour's by more than this, or "
                         "the object does; 0: everywhere")
    precision: Literal[64, 32] = Field(default=64, description="bits of the numbers a picture is computed in")

    @model_validator(mode="after")
    def _is_bounded(self):
        if self.max_distance / self.step_size > MOST_STEPS:
            raise ValueError(f"max_distance / step_size must be at most {MOST_STEPS} steps")
        return self


class AsPublished(Part):
    """What the document's figure shows where its text says otherwise: a JSON merge patch (RFC 7386) of the scene."""

    camera: dict[str, JsonValue] | None = None
    objects: list[JsonValue] | None = Field(None, description="like every list of a merge patch, in place of the scene's")
    lights: list[JsonValue] | None = None
    background: list[JsonValue] | None = None
    tracing: dict[str, JsonValue] | None = None

    @model_serializer(mode="wrap")
    def _written(self, handler):
        return {key: value for key, value in handler(self).items() if key in self.model_fields_set}  # null would remove

    def __hash__(self):
        return hash(self.model_dump_json())


def _merged(target, patch):
    """`target` changed by a JSON merge patch: objects key by key, null removes, all else replaces."""
    if not isinstance(patch, dict):
        return patch
    kept = {key: value for key, value in target.items() if patch.get(key, ...) is not None} if isinstance(target, dict) else {}
    return kept | {key: _merged(kept.get(key), value) for key, value in patch.items() if value is not None}


class Scene(Part):
    """A whole scene: what is seen, from where, in what light, and how it is traced."""

    schema_: str | None = Field(default=None, alias="$schema", max_length=500)
    format: Literal[1] = Field(default=1, description="version of this format")
    name: Annotated[str, Field(pattern=r"^[a-z0-9][a-z0-9.-]{0,79}$")] = Field(
        default="untitled", description="lower-case letters, digits, dots and hyphens; names output files")
    title: ShortText = ""
    figure: ShortText = Field(default="", description="the figure of the document this scene reproduces")
    description: Annotated[str, Field(max_length=2000)] = Field(default="", description="what the picture shows, in words")
    estimates: Annotated[str, Field(max_length=2000)] = Field(
        default="", description="which values are published, which were fitted to the figure, and which chosen by eye (S1)")
    camera: Camera = Camera()
    objects: Annotated[tuple[Object, ...], Field(min_length=1, max_length=MOST_OBJECTS)]
    lights: Annotated[tuple[Light, ...], Field(max_length=MOST_LIGHTS)] = ()
    background: tuple[Intensity, Intensity, Intensity] = (0.0, 0.0, 0.0)
    tracing: Tracing = Tracing()
    as_published: AsPublished | None = Field(
        None, description="what is otherwise in the document's figure (F1-F5): a merge patch of this scene; empty: nothing")

    @model_validator(mode="after")
    def _keeps_its_promises(self):
        if fault := broken(self):
            raise ValueError(fault)
        return self

    def casts_shadow(self, obj: Object) -> bool:
        """Whether `obj` dims the light that crosses it (decisions L3, F3)."""
        return obj.shadow and not (self.tracing.shadows == "opaque_only" and obj.material.transparency > 0)

    @property
    def switches(self) -> tuple[str, ...]:
        """The decisions that the scene takes otherwise than the document's text."""
        default = lambda part, field: type(part).model_fields[field].default
        return tuple(id for id, (name, *fields) in SWITCHES.items()
                     if any(getattr(part := getattr(self, name), field) != default(part, field) for field in fields))

    @property
    def hash(self) -> str:
        """SHA-256 of everything that can change a pixel; names and descriptions do not count."""
        content = self.model_dump(mode="json", by_alias=True, exclude={"schema_", "name", "title", "figure", "description",
                                                                      "estimates", "as_published"})
        for object_ in content["objects"]:
            object_.pop("name")
        return hashlib.sha256(json.dumps(content, sort_keys=True).encode()).hexdigest()

    def figure_form(self) -> Scene:
        """The scene as the document's figure shows it: this one, which is what the text says, with `as_published` merged in.

        Raises InputError if the scene does not tell of its figure, pydantic's ValidationError if the patch makes no scene.
        """
        if self.as_published is None:
            raise InputError(f'{self.name}: has no "as_published", which would say what its figure shows; leave it as it is')
        text = self.model_dump(mode="json", by_alias=True, exclude={"as_published"})
        patch = {"name": f"{self.name[:80 - len(AS_PUBLISHED)]}{AS_PUBLISHED}", **self.as_published.model_dump(mode="json")}
        return Scene.model_validate_json(json.dumps(_merged(text, patch)))

    def resized(self, width: int, height: int, samples: int | None = None) -> Scene:
        """The same scene at another picture size and, if given, another number of samples per axis."""
        tracing = self.tracing if samples is None else self.tracing.model_copy(update={"samples": samples})
        tracing = Tracing.model_validate(tracing.model_dump())
        return self.seen_by(width=width, height=height).model_copy(update={"tracing": tracing})

    def seen_by(self, **changes) -> Scene:
        """The same scene from a camera that differs in `changes`."""
        camera = Camera.model_validate({**self.camera.model_dump(), **changes})
        return self.model_copy(update={"camera": camera})

    def traced_with(self, **changes) -> Scene:
        """The same scene with other tracing parameters."""
        tracing = Tracing.model_validate({**self.tracing.model_dump(), **changes})
        return self.model_copy(update={"tracing": tracing})


def json_schema() -> dict:
    """The JSON Schema of a scene file."""
    schema = Scene.model_json_schema(by_alias=True)
    return {"$schema": "https://json-schema.org/draft/2020-12/schema", **schema, "title": "raytruth scene, format 1"}
