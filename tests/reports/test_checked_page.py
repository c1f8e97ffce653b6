"""The page of one check stands alone, shows the pictures that were compared, and shows text as text."""

import base64
import io
import re

import numpy as np
import pytest
from PIL import Image

from raytruth.reference_tracer.errors import InputError
from raytruth.reports import checked

HOSTILE = '<script>alert("x")</script><img src=x onerror=alert(1)>'
NONE = np.zeros((2, 3), bool)


def page(tmp_path, *pairs, **changes):
    content = {"title": "mine", "holds": False, "lines": ["2 of 3 cases hold"], "causes": [], "rows": (), "shown": pairs} | changes
    checked.write(tmp_path / "check.html", **content)
    return (tmp_path / "check.html").read_text(encoding="utf-8")


def pictures(text) -> list[np.ndarray]:
    return [np.asarray(Image.open(io.BytesIO(base64.b64decode(data))).convert("RGB"))
            for data in re.findall(r'src="data:image/png;base64,([^"]+)"', text)]


def test_it_shows_both_pictures_and_where_they_differ(tmp_path):
    truth, shown = np.zeros((2, 3, 3)), np.zeros((2, 3, 3))
    truth[..., 0], shown[..., 0] = 1, 1
    shown[1, 2] = 0, 1, 0
    text = page(tmp_path, checked.Beside("ball", truth, shown, NONE, NONE, NONE))
    found = [p for p in pictures(text) if p.shape == (2, 3, 3)]
    assert any((p == truth * 255).all() for p in found) and any((p == shown * 255).all() for p in found)
    errors, = (p for p in found if not (p == truth * 255).all() and not (p == shown * 255).all())
    assert (errors[0] == errors[0, 0]).all() and (errors[1, 2] != errors[0, 0]).any()


def test_it_refers_to_nothing_else(tmp_path):
    text = page(tmp_path, checked.Beside("ball", np.ones((2, 3, 3)), np.zeros((2, 3, 3)), NONE, NONE, NONE))
    for target in re.findall(r'(?:src|href)="([^"]*)"', text):
        assert target.startswith(("data:", "#")), target
    assert not re.findall(r"""url\((?!["']?(data:|%23))""", text) and "@import" not in text


def test_what_a_port_says_is_text(tmp_path):
    text = page(tmp_path, checked.Beside(HOSTILE, np.ones((2, 3, 3)), np.zeros((2, 3, 3)), NONE, NONE, NONE), title=HOSTILE,
                lines=[HOSTILE], causes=[HOSTILE], rows=[checked.Row("fail", (HOSTILE, HOSTILE))])
    assert "<script" not in text and "onerror=alert" not in re.sub("&lt;.*?&gt;", "", text)
    assert text.count("&lt;script&gt;") >= 6


def test_what_fails_comes_before_what_holds(tmp_path):
    text = page(tmp_path, rows=[checked.Row("pass", ("first asked",)), checked.Row("fail", ("second asked",))])
    assert text.index("second asked") < text.index("first asked")


def test_a_place_that_cannot_be_written_is_one_sentence(tmp_path):
    (tmp_path / "check.html").mkdir()
    with pytest.raises(InputError, match="check.html: cannot be written"):
        page(tmp_path)
