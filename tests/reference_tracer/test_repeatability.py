"""A picture repeats to the last bit: in another process, with another number of threads, and by wider kernels."""

import json
import os
import subprocess
import sys

import numpy as np
import pytest
from tracing_support import make_scene, thing

from raytruth.reference_tracer import llvm
from raytruth.reference_tracer.tracer import wavefront
from raytruth.reference_tracer.tracer.render import UNDECIDED, Watch, render
from raytruth.reference_tracer.tracer.shading import interact

OUTSIDE = """
import hashlib, json, sys
from raytruth.reference_tracer.tracer.render import render
from raytruth.reference_tracer.tracer.film import PLANES
from raytruth.reference_tracer.scene import library
name, method, precision, threads, adaptive = json.loads(sys.argv[1])
scene = library.scene(name).resized(96, 72, samples=3).traced_with(adaptive=adaptive)
picture = render(scene, method, precision=precision, threads=threads)
print(json.dumps({plane: hashlib.sha256(getattr(picture, plane).tobytes()).hexdigest() for plane in PLANES}))
"""


LANES = """
from raytruth.reference_tracer.backend import backend
import drjit as dr
with dr.scoped_set_flag(dr.JitFlag.KernelHistory):
    dr.eval(dr.sqrt(dr.arange(backend().Float, 100) + backend().constant(1.5)))
print(max(kernel["ir"].getvalue().count("<4 x double>") for kernel in dr.kernel_history() if "ir" in kernel))
"""


def outside(*case, narrow: str = "") -> dict[str, str]:
    """A hash of every plane, computed by another process."""
    return json.loads(_run(OUTSIDE, json.dumps(case), narrow=narrow))


def _run(program: str, *arguments: str, narrow: str) -> str:
    return subprocess.run([sys.executable, "-c", program, *arguments], env={**os.environ, llvm.NARROW: narrow},
                          capture_output=True, text=True, check=True).stdout


@pytest.mark.parametrize("method, precision, adaptive", [("exact", 64, 0.0), ("paper", 64, 0.0), ("exact", 32, 0.0),
                                                         ("exact", 64, 0.05)])
def test_two_processes_with_one_and_two_threads_render_the_same_bits(method, precision, adaptive):
    """Recursion (mirrors and glass) and 3 x 3 samples: many rays of one pixel are added at once."""
    case = "figure-17-scene1", method, precision
    assert outside(*case, 1, adaptive) == outside(*case, 2, adaptive) == outside(
        *case, 2, adaptive, narrow="1" if precision == 64 else "")  # narrow kernels divide more exactly in fp32


def test_narrow_kernels_are_narrow():
    asked = "from raytruth.reference_tracer import llvm\nllvm.narrow_kernels()\n" + LANES
    assert int(_run(LANES, narrow="1")) > 0 and int(_run(asked, narrow="")) > 0
    wide = int(_run(LANES, narrow=""))
    assert int(_run(asked, narrow="0")) == wide  # tests share a process, and Mitsuba's fp32 would change in all of them


def _mirrors(**rest):
    ball = lambda x: thing("sphere", (x, 0, 4), r=1, material={"color": [0.9, 0.5, 0.3], "reflection": 0.6})
    return make_scene(ball(-1.1), ball(1.1), size=(24, 18), samples=2, **rest)


@pytest.mark.parametrize("brightness", [1e-285, 1e-12, 1.0, 1000.0])
def test_colours_have_the_digits_of_the_brightest_whatever_its_size(brightness):
    """Brightness scales a picture, up to rounding and the units that colours are counted in."""
    dim = render(_mirrors(lights=[((0, 3, 0), [brightness] * 3)])).color
    one = render(_mirrors(lights=[((0, 3, 0), [1.0] * 3)])).color
    assert one.max() > 0.3
    np.testing.assert_allclose(dim / brightness, one, rtol=0, atol=2.0**-52)


def test_a_colour_that_is_not_finite_is_never_a_decided_number(monkeypatch):
    """No scene makes one; a shading that does is noticed, in its pixels and in no others."""
    def spoilt(world, ray, active):
        interaction = interact(world, ray, active)
        x = interaction.point[0]
        interaction.color[0] = world.arrays.Float(np.where(np.arange(len(x)) % 3 == 0, np.inf, interaction.color[0].numpy()))
        return interaction

    scene = make_scene(thing("sphere", (0, 0, 4), r=1), size=(8, 6), lights=[((0, 3, 0), (1, 1, 1))])
    right = render(scene)
    monkeypatch.setattr(wavefront, "interact", spoilt)
    picture = render(scene, watch=Watch())  # watched renders are not recorded
    spoilt_ones = (np.arange(48) % 3 == 0).reshape(6, 8)
    assert np.isnan(picture.color[spoilt_ones]).all() and (picture.status[spoilt_ones] == UNDECIDED).all()
    assert np.array_equal(picture.color[~spoilt_ones], right.color[~spoilt_ones])
    assert np.array_equal(picture.status[~spoilt_ones], right.status[~spoilt_ones])
