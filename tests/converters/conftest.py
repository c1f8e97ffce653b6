import pytest

from raytruth.reference_tracer.scene.model import Camera, Light, Object, Scene


@pytest.fixture(autouse=True)
def no_mesh_of_another_test():
    """A test that changes how surfaces are evaluated must not be given a mesh that was made before."""
    from raytruth.converters.mesh import convert

    convert._kept.clear()
    yield
    convert._kept.clear()


@pytest.fixture
def scene_of():
    """A scene of the given surfaces or objects, seen by a small camera in the light of one lamp."""
    def build(*things, width=96, height=72, **parts):
        objects = tuple(t if isinstance(t, Object) else Object(surface=t) for t in things)
        camera, lights = Camera(width=width, height=height), (Light(position=(2.0, 3.0, -1.0)),)
        return Scene(objects=objects, **{"camera": camera, "lights": lights, **parts})
    return build


@pytest.fixture
def mesh_of(scene_of):
    """The mesh of one surface or object alone in a scene."""
    from raytruth.converters.mesh import mesh_object

    def build(thing, resolution=64, **parts):
        scene = scene_of(thing, **parts)
        return mesh_object(scene.objects[0], scene, resolution)
    return build
