"""Shared by all tests: Dr.Jit must find its LLVM before any test module imports it."""

import os
import sys
from collections import OrderedDict

import pytest
from flint import ctx

from raytruth import reference_tracer  # noqa: F401  chooses the LLVM library
from raytruth.reference_tracer import llvm

# tests share processes, and a command that asks for narrow kernels changes fp32 in all later ones: all are narrow or none
os.environ.setdefault(llvm.NARROW, "0")
os.environ.pop("COLUMNS", None)  # a worker of pytest-xdist has 80, as if there were a terminal

# files of tests that take more than some seconds together (`pytest --durations=0`): `make check` leaves them out
SLOW = {
    "accumulation", "attribution", "attribution_suite", "backend", "bench", "bounds", "broken_methods", "bundle",
    "certify", "certify_multiple_roots", "certify_switches", "certify_tangency", "chart_suite", "check_image", "cluster",
    "clip", "command_line", "compilation", "conditioning", "cpp_port", "decisions", "docs", "document", "effects",
    "embree", "enclosures", "extending", "figure_switches", "figure_switches_elsewhere", "first_hit", "formulas",
    "hostile_inputs", "hostile_ports", "interpreter", "interrupted_suites", "intervals", "laws", "matrix", "memory_bands",
    "mesh_clipping", "mesh_closed_forms", "mesh_error", "meshes", "misbehaving", "mitsuba_geometry", "mitsuba_grids",
    "mitsuba_picture", "mitsuba_refined", "mutants", "nearest_scene", "not_finite", "odd_parts", "oracle",
    "pixel_limits", "plan", "pool", "port_checks", "povray_picture", "povray_scene", "random_scenes",
    "renderer_mutants", "repeatability", "report_build", "report_stability", "report_transport",
    "right_is_never_odd", "sensitivity", "store", "suite", "ties", "transport_cases", "transport_suite",
    "wavefront_against_recursion"}


# files in which fp32 has to keep its limits: `make test` compiles kernels for them as users do, for all others narrow ones,
# whose pictures in fp64 have the same bits (test_repeatability.py)
WIDE = {"exports", "mitsuba_geometry", "mitsuba_grids", "mitsuba_picture", "mitsuba_refined", "nearest_scene",
        "right_is_never_odd", "transport_cases"}

# files of half a minute and more: begun first, so that no processor waits for one of them at the end
LONG = ("port_checks", "povray_picture", "report_browser", "check_image", "accumulation", "pool", "interrupted_suites", "cluster",
        "oracle", "right_is_never_odd", "hostile_inputs")


def pytest_collection_modifyitems(items):
    place = {name: k for k, name in enumerate(LONG)}
    items.sort(key=lambda item: place.get(item.path.stem.removeprefix("test_"), len(LONG)))  # stable: all else stays
    for item in items:
        if item.path.stem.removeprefix("test_") in SLOW:
            item.add_marker("slow")
        if item.path.stem.removeprefix("test_") in WIDE:
            item.add_marker("wide")


@pytest.fixture(autouse=True)
def own_recordings(monkeypatch):
    """What is recorded of a tracer that a test has changed is replayed in no other test."""
    if "raytruth.reference_tracer.tracer.render" in sys.modules:
        monkeypatch.setattr(sys.modules["raytruth.reference_tracer.tracer.render"], "_shared", OrderedDict())
    if "raytruth.converters.mesh.convert" in sys.modules:  # where a worker's function, called here, has put meshes
        monkeypatch.setattr(sys.modules["raytruth.converters.mesh.convert"], "shelf", None)


@pytest.fixture(autouse=True)
def same_precision():
    """Who sets flint's precision sets it back: it is one for the whole process."""
    before = ctx.prec, ctx.cap
    yield
    left = ctx.prec, ctx.cap
    ctx.prec, ctx.cap = before  # or every later test would fail for it
    assert left == before


@pytest.fixture
def as_written(monkeypatch):
    """Formulas are traced as they are written, not by their odd parts: for methods that have to bear any f."""
    from raytruth.reference_tracer.surfaces import expression

    monkeypatch.setattr(expression, "odd_part", lambda tree: tree)
    expression.forms_of.cache_clear()
    yield
    expression.forms_of.cache_clear()
