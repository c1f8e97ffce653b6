"""Ground truth for ray tracers of implicit surfaces, from Python. The command line does the same and more.

    import raytruth as rt
    scene = rt.find_scene("figure-07-torus").resized(160, 120)     # or rt.load_scene("mine.json"), or built:
    torus = rt.Object(surface=rt.Torus(center=(0, 0, 4), R=1, r=0.4), material=rt.Material(color=(0.9, 0.6, 0.2)))
    scene = rt.Scene(objects=(torus,), lights=(rt.Light(position=(2, 3, 0)),))

    picture = rt.render(scene)                        # Picture: shows itself in a notebook
    picture.color, picture.t, picture.normal          # planes as NumPy arrays, row 0 at the top
    rt.save(picture, "torus.exr")                     # .png, .exr or .npz
    other = rt.render_with("embree", scene)           # by another renderer
    print(rt.compare(picture, other))                 # the judge of the suites: verdict, reason, gates, numbers
    rt.mesh(scene, 0).show()                          # a trimesh.Trimesh
    rt.export(scene, "torus.pov")                     # .ply .obj .stl .glb .xml .pov .txt

Whatever is wrong with what they are given is an InputError of one sentence.
"""

from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any

_HERE = Path(__file__).parent
if not (_HERE / "reference_tracer").is_dir():  # a checkout, where the packages stand beside this one; a wheel has them inside
    __path__.append(str(_HERE.parent))

if TYPE_CHECKING:
    from raytruth.comparisons.renderers import render as render_with
    from raytruth.comparisons.verdicts.pictures import Compared, compare
    from raytruth.converters.export import Exported, export, mesh
    from raytruth.reference_tracer.errors import InputError
    from raytruth.reference_tracer.scene.library import find as find_scene
    from raytruth.reference_tracer.scene.library import names as scene_names
    from raytruth.reference_tracer.scene.load import load_scene
    from raytruth.reference_tracer.scene.model import Camera, Light, Material, Object, Rotation, Scene, Tracing
    from raytruth.reference_tracer.surfaces import Bounds, Ellipsoid, Expression, Heart, Paraboloid, Plane, Sphere, Torus
    from raytruth.reference_tracer.tracer.image_files import save
    from raytruth.reference_tracer.tracer.render import Picture, render

_SURFACES = ("Bounds", "Ellipsoid", "Expression", "Heart", "Paraboloid", "Plane", "Sphere", "Torus")
_PARTS = ("Camera", "Light", "Material", "Object", "Rotation", "Scene", "Tracing")
# what is imported when it is used: the command line starts without the array library
_HOME = {"load_scene": ("reference_tracer.scene.load", "load_scene"), "find_scene": ("reference_tracer.scene.library", "find"),
         "scene_names": ("reference_tracer.scene.library", "names"),
         **{name: ("reference_tracer.scene.model", name) for name in _PARTS},
         **{name: ("reference_tracer.surfaces", name) for name in _SURFACES},
         "render": ("reference_tracer.tracer.render", "render"), "Picture": ("reference_tracer.tracer.render", "Picture"),
         "render_with": ("comparisons.renderers", "render"), "save": ("reference_tracer.tracer.image_files", "save"),
         "compare": ("comparisons.verdicts.pictures", "compare"), "Compared": ("comparisons.verdicts.pictures", "Compared"),
         "mesh": ("converters.export", "mesh"), "export": ("converters.export", "export"),
         "Exported": ("converters.export", "Exported"), "InputError": ("reference_tracer.errors", "InputError")}

__all__ = ["Bounds", "Camera", "Compared", "Ellipsoid", "Exported", "Expression", "Heart", "InputError", "Light", "Material",
           "Object", "Paraboloid", "Picture", "Plane", "Rotation", "Scene", "Sphere", "Torus", "Tracing", "compare", "export",
           "find_scene", "load_scene", "mesh", "render", "render_with", "save", "scene_names"]


def __getattr__(name: str) -> Any:
    if name not in _HOME:
        raise AttributeError(f"module 'raytruth' has no attribute {name!r}")
    module, own = _HOME[name]
    return getattr(import_module(f"raytruth.{module}"), own)


def __dir__() -> list[str]:
    return sorted(__all__)
