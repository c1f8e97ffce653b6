"""Which LLVM is taken, which array types, and what single precision is worth."""

import os
import subprocess
import sys

import drjit as dr
import numpy as np
import pytest
from tracing_support import make_scene, thing

from raytruth.reference_tracer import llvm
from raytruth.reference_tracer.backend import backend
from raytruth.reference_tracer.errors import InputError
from raytruth.reference_tracer.tracer.render import render


def folder_with(path, *names):
    (path / "lib").mkdir(parents=True)
    for name in names:
        (path / "lib" / name).touch()
    return path


@pytest.mark.parametrize("names, chosen", [
    (["libLLVM-15.so", "libLLVM-19.so", "libLLVM.so.17.0.6"], "libLLVM-19.so"),
    (["libLLVM.so.23.1", "libLLVM-16.so"], "libLLVM.so.23.1"),
    (["libLLVM-9.so", "libLLVM-14.so.1"], None), (["libclang.so.19", "libLLVM.so"], None), ([], None)])
def test_the_newest_usable_llvm_of_the_environment_is_found(tmp_path, monkeypatch, names, chosen):
    """Versions below 16 abort the process on some of Dr.Jit's kernels: rather none than one of those."""
    data = folder_with(tmp_path, *names)
    monkeypatch.setattr(llvm.sysconfig, "get_path", lambda _: str(data))
    found = llvm.find()
    if chosen:
        assert found == data / "lib" / chosen
    else:
        assert found is None or data not in found.parents


def chosen_in_a_fresh_process(chosen: str | None) -> list[str]:
    """The variable after importing the package alone, and whether that has imported Dr.Jit."""
    code = f"import os, sys, reference_tracer; print(os.environ.get({llvm.VARIABLE!r}), 'drjit' in sys.modules)"
    environment = {key: value for key, value in os.environ.items() if key not in (llvm.VARIABLE, llvm.NARROW)}
    environment |= {llvm.VARIABLE: chosen} if chosen else {}
    return subprocess.run([sys.executable, "-c", code], env=environment, capture_output=True, text=True,
                          check=True).stdout.split()


def test_llvm_is_chosen_before_anything_imports_drjit():
    chosen, imported = chosen_in_a_fresh_process(None)
    assert "libLLVM" in chosen and imported == "False"


def test_the_user_s_choice_of_llvm_is_never_overridden():
    assert chosen_in_a_fresh_process("/chosen/by/the/user.so") == ["/chosen/by/the/user.so", "False"]


RENDERS = """
import sys
import raytruth
scene = raytruth.find_scene("effect-shadow").resized(8, 6)
try:
    print(raytruth.render(scene).metadata["rays"])
except raytruth.InputError as error:
    sys.exit(f"refused: {error}")
"""
CONVERTS = """
import sys
from raytruth.reference_tracer.errors import InputError
try:
    import raytruth.converters.mitsuba.variant
except InputError as error:
    sys.exit(f"refused: {error}")
"""


@pytest.mark.parametrize("first, then", [
    ("import drjit", RENDERS), ("import drjit.llvm as l; import drjit; drjit.eval(l.Float([1, 2]) + 1)", RENDERS),
    ("import mitsuba; mitsuba.set_variant('llvm_ad_rgb')", RENDERS),
    ("import drjit", CONVERTS), ("import mitsuba; mitsuba.set_variant('scalar_rgb')", CONVERTS)])
def test_an_llvm_that_somebody_else_has_loaded_is_used_or_refused_in_one_sentence(tmp_path, first, then):
    """Old ones abort the process on some kernels. From another folder, as a user's program would."""
    environment = {key: value for key, value in os.environ.items() if key not in (llvm.VARIABLE, llvm.NARROW)}
    root = os.path.dirname(os.path.dirname(llvm.__file__))
    program = f"import sys; sys.path.insert(0, {root!r})\n{first}\nimport drjit; print(drjit.detail.llvm_version()[0])\n{then}"
    process = subprocess.run([sys.executable, "-c", program], env=environment, cwd=tmp_path, capture_output=True, text=True)
    if not process.stdout:
        assert "llvm" in process.stderr.lower()  # Dr.Jit itself finds none on this machine
    elif int(process.stdout.split()[0]) >= llvm.OLDEST:
        assert process.returncode == 0, process.stderr
    else:
        assert process.returncode == 1 and process.stderr.count("\n") == 1
        assert process.stderr.startswith("refused: drjit or mitsuba was imported before raytruth")
        assert "import raytruth first" in process.stderr


def test_an_old_llvm_of_the_user_s_choice_is_refused_by_its_name(monkeypatch):
    monkeypatch.setenv(llvm.VARIABLE, "/chosen/libLLVM-15.so")
    monkeypatch.setattr(dr.detail, "llvm_version", lambda: (15, 0, 6))
    monkeypatch.setattr(llvm, "chosen_by_user", True)
    with pytest.raises(InputError, match="^/chosen/libLLVM-15.so is LLVM 15.0.6, whose kernels may abort .*install karellen"):
        llvm.require()


def test_a_missing_backend_is_told(monkeypatch):
    monkeypatch.setenv(llvm.VARIABLE, "")
    with pytest.raises(InputError, match="LLVM"):
        backend.__wrapped__(64, "llvm")
    if not dr.has_backend(dr.JitBackend.CUDA):
        with pytest.raises(InputError, match="CUDA"):
            backend(64, "cuda")


def test_an_unknown_method_is_told():
    with pytest.raises(InputError, match="'guess'.*exact"):
        render(make_scene(thing("sphere", (0, 0, 4), r=1)), "guess")


def test_single_precision_is_close_and_not_the_truth():
    """24 bits instead of 53: away from edges a colour is off by 1e-8 to 1e-4."""
    scene = make_scene(thing("sphere", (0, 0, 4), r=1), size=(16, 12), camera={"fov": 25},
                       lights=[((3, 3, 0), (1, 1, 1))])
    error = np.abs(render(scene, precision=32).color - render(scene).color)
    assert 1e-9 < np.median(error[error > 0]) < 1e-5 and np.percentile(error, 90) < 1e-3
