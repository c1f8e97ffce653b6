"""Pictures that others made are read as they are meant, and what is none is refused in one sentence."""

import io
import pickle
import struct
import zipfile
import zlib

import numpy as np
import pytest

from raytruth.comparisons.ports.picture import read
from raytruth.reference_tracer.errors import InputError
from raytruth.reference_tracer.scene import library
from raytruth.reference_tracer.tracer.image_files import save, write_8_bit
from raytruth.reference_tracer.tracer.render import render

COLOR = np.random.default_rng(3).uniform(0, 1.4, (6, 8, 3))


def bytes_of(color):
    return np.rint(np.clip(color, 0, 1) * 255).astype(np.uint8)


def test_every_format_gives_the_same_rows_and_channels(tmp_path):
    np.save(tmp_path / "a.npy", COLOR)
    np.save(tmp_path / "single.npy", COLOR.astype(np.float32))
    np.save(tmp_path / "first.npy", np.moveaxis(COLOR, -1, 0))
    np.savez(tmp_path / "a.npz", color=COLOR, other=np.zeros(3))
    np.savez_compressed(tmp_path / "one.npz", anything=COLOR)
    write_8_bit(bytes_of(COLOR), tmp_path / "a.png")
    head = b"PF\n8 6\n-1.0\n"
    (tmp_path / "a.pfm").write_bytes(head + COLOR[::-1].astype("<f4").tobytes())
    (tmp_path / "big.pfm").write_bytes(b"PF\n8 6\n1.0\n" + COLOR[::-1].astype(">f4").tobytes())
    for name in ("a.npy", "first.npy", "a.npz", "one.npz"):
        assert np.array_equal(read(tmp_path / name).color, COLOR), name
        assert read(tmp_path / name).tolerance == 0
    for name in ("single.npy", "a.pfm", "big.pfm"):
        assert np.array_equal(read(tmp_path / name).color, COLOR.astype(np.float32)), name
    png = read(tmp_path / "a.png")
    assert png.levels == 255 and np.array_equal(png.color * 255, bytes_of(COLOR))


def test_ours_are_read_back(tmp_path):
    picture = render(library.scene("effect-shading").resized(16, 12), "exact")
    for suffix, error in ((".png", 0.5 / 255 + 1e-12), (".exr", 2.0**-23), (".npz", 0)):
        save(picture, tmp_path / f"a{suffix}")
        found = read(tmp_path / f"a{suffix}")
        assert np.abs(found.color - np.clip(picture.color, 0, 1)).max() <= error and error >= found.tolerance


def test_what_a_file_is_is_told(tmp_path):
    said = lambda array: (np.save(tmp_path / "a.npy", array), read(tmp_path / "a.npy"))[1]
    assert said(bytes_of(COLOR)).levels == 255
    assert said((np.clip(COLOR, 0, 1) * 65535).astype(np.uint16)).levels == 65535
    quantised = said(bytes_of(COLOR).astype(np.float32) / 255)
    assert quantised.levels == 255 and any("1/255" in told for told in quantised.told)
    assert said(bytes_of(COLOR).astype(float)).levels == 255
    alpha = said(np.concatenate([COLOR, np.full((6, 8, 1), 0.5)], axis=-1))
    assert alpha.color.shape == (6, 8, 3) and any("alpha is below 1 in 48" in told for told in alpha.told)
    assert said(COLOR[..., 0]).color.shape == (6, 8, 3)
    assert np.isnan(said(np.full((6, 8, 3), np.nan)).color).all()


def _png(width, height, data):
    chunk = lambda kind, body: struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body))
    return (b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0))
            + chunk(b"IDAT", zlib.compress(data)) + chunk(b"IEND", b""))


def _npy(shape, kind="<f8", body=b""):
    head = f"{{'descr': '{kind}', 'fortran_order': False, 'shape': {shape}, }}".encode()
    return b"\x93NUMPY\x01\x00" + struct.pack("<H", len(head) + 1) + head + b"\n" + body


def _npz(**members):
    file = io.BytesIO()
    with zipfile.ZipFile(file, "w") as archive:
        for name, content in members.items():
            archive.writestr(f"{name}.npy", content)
    return file.getvalue()


class Bomb:
    def __reduce__(self):
        return (exec, ("raise SystemExit('executed')",))


GOOD_PNG = _png(8, 6, b"".join(b"\0" + bytes(24) for _ in range(6)))
HOSTILE = {
    "truncated.png": (GOOD_PNG[:60], "cannot be read"),
    "empty.png": (b"", "cannot be read"),
    "text.png": (b"<script>alert(1)</script>", "cannot be read"),
    "huge.png": (_png(20_000, 20_000, b""), "cannot be read"),
    "huge.npy": (_npy((40000, 40000, 3)), "40000, 40000, 3"),
    "overflowing.npy": (_npy((2**62, 2**62, 3)), "can be checked at most"),
    "negative.npy": (_npy((-1, 8, 3)), "cannot be read"),
    "short.npy": (_npy((6, 8, 3), body=bytes(100)), "cannot be read"),
    "pickled.npy": (_npy((1,), "|O", pickle.dumps(Bomb())), "Python objects"),
    "pickled.npz": (_npz(color=_npy((1,), "|O", pickle.dumps(Bomb()))), "Python objects"),
    "shape.npy": (_npy((6, 8, 3, 3), body=bytes(6 * 8 * 9 * 8)), "(height, width, 3)"),
    "complex.npy": (_npy((6, 8, 3), "<c16", bytes(6 * 8 * 3 * 16)), "complex"),
    "flags.npy": (_npy((6, 8, 3), "|b1", bytes(144)), "bool"),
    "zero.npy": (_npy((0, 8, 3)), "0 pixels"),
    "two.npz": (_npz(a=_npy((1,), body=bytes(8)), b=_npy((1,), body=bytes(8))), "none called color"),
    "nozip.npz": (b"PK\x03\x04 nothing", "cannot be read"),
    "huge.pfm": (b"PF\n99999 99999\n-1.0\n", "99999 x 99999"),
    "short.pfm": (b"PF\n8 6\n-1.0\n" + bytes(10), "fewer bytes"),
    "scale.pfm": (b"PF\n8 6\nnan\n" + bytes(576), "scale"),
    "head.pfm": (b"P6\n8 6\n255\n" + bytes(144), "PF or Pf"),
    "broken.exr": (b"\x76\x2f\x31\x01\x02\x00\x00\x00" + bytes(50), "cannot be read"),
    "picture.gif": (b"GIF89a", "must end in"),
}


@pytest.mark.parametrize("name", HOSTILE)
def test_what_is_no_picture_is_refused_in_one_sentence(tmp_path, name):
    content, says = HOSTILE[name]
    (tmp_path / name).write_bytes(content)
    with pytest.raises(InputError) as error:
        read(tmp_path / name)
    assert says in str(error.value) and "\n" not in str(error.value)


def test_no_file_and_a_folder_are_refused(tmp_path):
    (tmp_path / "folder.png").mkdir()
    for name in ("missing.png", "folder.png"):
        with pytest.raises(InputError, match="no such file"):
            read(tmp_path / name)
