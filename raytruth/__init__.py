"""The facade and the command line of raytruth.

    import raytruth
    picture = raytruth.render(raytruth.find_scene("figure-05-sphere"), "exact")
    picture.color  # (height, width, 3) fp64
"""

from importlib import import_module

_HOME = {"Picture": "reference_tracer.tracer.render", "render": "reference_tracer.tracer.render",
         "find_scene": "reference_tracer.scene.library", "load_scene": "reference_tracer.scene.load",
         "InputError": "reference_tracer.errors", "save": "reference_tracer.tracer.image_files"}
_RENAMED = {"find_scene": "find"}

__all__ = list(_HOME)


def __getattr__(name: str):  # imported when used: the command line starts without the array library
    if name not in _HOME:
        raise AttributeError(f"module 'raytruth' has no attribute {name!r}")
    return getattr(import_module(_HOME[name]), _RENAMED.get(name, name))
