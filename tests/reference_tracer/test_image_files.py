"""Section 5 and decision P1: what the files hold, read back by OpenImageIO and NumPy."""

import json

import numpy as np
import OpenImageIO as oiio
import pytest
from tracing_support import make_scene, thing

from raytruth.reference_tracer.errors import InputError
from raytruth.reference_tracer.tracer.image_files import PLANES, load_npz, save, to_8_bit, write_8_bit
from raytruth.reference_tracer.tracer.render import HIT, MISS, render


@pytest.fixture(scope="module")
def picture():
    """A ball lit so brightly that colours exceed 1, on a floor, under a sky: hits, misses, values beyond 8 bits."""
    scene = make_scene(thing("sphere", (0, 0, 4), r=1, material={"color": [1, 0.5, 0.25], "reflection": 0.3}),
                       thing("plane", (0, -1, 0), a=0, b=1, c=0), lights=[((2, 3, 0), (3, 2, 1))], size=(20, 15),
                       background=(0.11, 0.22, 0.33))
    found = render(scene, "exact", threads=2)
    assert found.color.max() > 1.5 and {HIT, MISS} == set(np.unique(found.status)) and found.depth.max() == 1
    return found


def read(path):
    """(pixels, channel names, header) of an image file; pixels as the file holds them."""
    image = oiio.ImageBuf(str(path))
    kind = {"uint8": oiio.UINT8, "float": oiio.FLOAT}[str(image.spec().format)]
    return image.get_pixels(kind), list(image.spec().channelnames), image.spec()


def test_P1_eight_bits_clamp_and_round_to_nearest_without_gamma():
    """v 255 rounded to nearest: 0.1 is 25.5 in decimal, in binary 25.500000000000001; 127.4/255 and 127.6/255 part."""
    values = np.array([-1.0, 0.0, 0.25, 0.4999 / 255, 0.5001 / 255, 127.4 / 255, 127.6 / 255, 1.0, 1.5, np.inf, -np.inf,
                       np.nan])
    assert to_8_bit(values).tolist() == [0, 0, 64, 0, 1, 127, 128, 255, 255, 255, 0, 0]
    every = np.arange(256) / 255
    assert to_8_bit(every).tolist() == list(range(256))


def test_P1_png_holds_the_rounded_colours(picture, tmp_path):
    save(picture, tmp_path / "picture.png")
    pixels, names, spec = read(tmp_path / "picture.png")
    assert names == ["R", "G", "B"] and pixels.dtype == np.uint8
    np.testing.assert_array_equal(pixels, np.rint(np.clip(picture.color, 0, 1) * 255))
    assert spec.getattribute("raytruth:scene_hash") in (picture.scene.hash, None)  # a PNG may drop unknown texts


def test_P1_exr_holds_linear_unclamped_values_and_every_plane(picture, tmp_path):
    save(picture, tmp_path / "picture.exr")
    pixels, names, spec = read(tmp_path / "picture.exr")
    assert sorted(names) == sorted(["R", "G", "B", "Z", "P.X", "P.Y", "P.Z", "N.X", "N.Y", "N.Z", "id.Y", "generation.Y",
                                    "status.Y"])
    channel = lambda *wanted: np.squeeze(pixels[..., [names.index(name) for name in wanted]])
    for wanted, plane in ((("R", "G", "B"), picture.color), (("Z",), picture.t),
                          (("P.X", "P.Y", "P.Z"), picture.position), (("N.X", "N.Y", "N.Z"), picture.normal),
                          (("id.Y",), picture.index), (("generation.Y",), picture.depth), (("status.Y",), picture.status)):
        np.testing.assert_array_equal(channel(*wanted), plane.astype(np.float32))
    assert channel("R").max() > 1.5 and np.isposinf(channel("Z")).any() and np.isnan(channel("P.X")).any()
    assert spec.getattribute("raytruth:scene_hash") == picture.scene.hash
    assert spec.getattribute("raytruth:method") == "exact" and spec.getattribute("raytruth:drjit")
    assert json.loads(spec.getattribute("raytruth:tracing"))["step_size"] == 0.1
    assert json.loads(spec.getattribute("raytruth:threads")) == 2


def test_mitsuba_splits_an_exr_into_layers(picture, tmp_path):
    """Another program's reading of the names: vectors for places and normals, numbers for what is counted, and colours."""
    from raytruth.converters.mitsuba.variant import mi

    save(picture, tmp_path / "picture.exr")
    layers = dict(mi.Bitmap(str(tmp_path / "picture.exr")).split())
    assert {name: layer.pixel_format() for name, layer in layers.items() if name != "<root>"} == {
        "P": mi.Bitmap.PixelFormat.XYZ, "N": mi.Bitmap.PixelFormat.XYZ, "id": mi.Bitmap.PixelFormat.Y,
        "generation": mi.Bitmap.PixelFormat.Y, "status": mi.Bitmap.PixelFormat.Y}
    root = [field.name for field in layers["<root>"].struct_()]
    assert sorted(root) == ["B", "G", "R", "Z"]
    np.testing.assert_array_equal(np.array(layers["<root>"])[..., [root.index(c) for c in "RGB"]], picture.color.astype(np.float32))
    for name, plane in (("P", picture.position), ("N", picture.normal)):
        np.testing.assert_array_equal(np.array(layers[name]), plane.astype(np.float32))
    for name, plane in (("id", picture.index), ("generation", picture.depth), ("status", picture.status)):
        np.testing.assert_array_equal(np.array(layers[name]).reshape(plane.shape), plane.astype(np.float32))


def test_npz_is_exact(picture, tmp_path):
    save(picture, tmp_path / "picture.npz")
    planes, about = load_npz(tmp_path / "picture.npz")
    assert set(planes) == set(PLANES)
    for name, plane in planes.items():
        original = getattr(picture, name)
        assert plane.dtype == original.dtype and plane.tobytes() == original.tobytes()
    assert about["scene_hash"] == picture.scene.hash and about["method"] == "exact" and about["raytruth"]
    assert about["tracing"]["max_depth"] == 8 and about["precision"] == 64 and about["rays"] > 300


def test_planes_agree_with_each_other(picture):
    """position = t d with the camera at the origin; |normal| = 1; nothing was hit where t is infinite."""
    hit = picture.index >= 0
    np.testing.assert_array_equal(hit, np.isfinite(picture.t))
    np.testing.assert_array_equal(hit, picture.status == HIT)
    np.testing.assert_allclose(np.linalg.norm(picture.position[hit], axis=-1), picture.t[hit], rtol=1e-14)
    np.testing.assert_allclose(np.linalg.norm(picture.normal[hit], axis=-1), 1, rtol=1e-14)
    assert np.isnan(picture.position[~hit]).all() and np.isnan(picture.normal[~hit]).all()


@pytest.mark.parametrize("name", ["picture.jpg", "picture", "no/such/folder/picture.png", "no/such/folder/picture.npz",
                                  "no/such/folder/picture.exr"])
def test_what_cannot_be_written_is_told(picture, tmp_path, name):
    with pytest.raises(InputError) as error:
        save(picture, tmp_path / name)
    assert name in str(error.value) and len(str(error.value).splitlines()) == 1
    assert not list(tmp_path.iterdir())


def test_grey_pictures_can_be_written(tmp_path):
    grey = np.arange(12, dtype=np.uint8).reshape(3, 4, 1)
    write_8_bit(grey, tmp_path / "grey.png")
    assert read(tmp_path / "grey.png")[0].ravel().tolist() == list(range(12))
