"""A gate that cannot be fooled: small faults that whole-image scores forgive must fail it, rounding must pass it."""

from dataclasses import astuple

import numpy as np
import pytest

from raytruth.comparisons.results import Run
from raytruth.comparisons.verdicts import metrics, tolerances
from raytruth.comparisons.verdicts.conditioning import Limits, apart
from raytruth.comparisons.verdicts.judge import judge
from raytruth.comparisons.verdicts.metrics import GRAZING
from raytruth.comparisons.verdicts.tolerances import MESH, NATIVE, concluded, unmeasured, unproven
from raytruth.reference_tracer.tracer.render import UNDECIDED

SIDE = 64


@pytest.fixture
def planes():
    """A unit sphere at distance 4 before the camera, lit from the camera: depth and colour in closed form."""
    y, x = np.mgrid[:SIDE, :SIDE]
    d = np.stack([(x + 0.5) / SIDE - 0.5, 0.5 - (y + 0.5) / SIDE, np.ones((SIDE, SIDE))], axis=-1)
    d /= np.linalg.norm(d, axis=-1, keepdims=True)
    center = np.array([0.0, 0.0, 4.0])
    b = d @ center  # t = b - sqrt(b^2 - (|c|^2 - r^2))
    discriminant = b**2 - 15.0
    hit = discriminant > 0
    t = np.where(hit, b - np.sqrt(np.where(hit, discriminant, 0)), np.inf)
    position = np.where(hit[..., None], d * np.where(hit, t, 0)[..., None], np.nan)
    normal = position - center
    cosine = -np.sum(d * normal, axis=-1)
    return {"color": np.where(hit, cosine, 0)[..., None] * np.array([1.0, 0.5, 0.25]), "t": t, "position": position,
            "normal": normal, "index": np.where(hit, 0, -1), "status": hit.astype(np.uint8), "camera": np.zeros(3),
            "depth": np.zeros((SIDE, SIDE), np.uint8)}


def changed(planes, **changes):
    return {**{name: plane.copy() for name, plane in planes.items()}, **changes}


def limits(planes):
    """Of a renderer in single precision: nothing hangs on rounding, every pixel may be off by a few units of it."""
    flat, none = np.full((SIDE, SIDE), 4e-6), np.zeros((SIDE, SIDE))
    return Limits(flat, flat * 4, flat, flat, flat * 4, flat, none.astype(np.uint8), none.astype(np.uint64), none > 0,
                  planes["status"] != UNDECIDED)


def measured_on(reference, test):
    return {**metrics.geometry(reference, test), **metrics.picture(reference, test), **apart(reference, test, limits(reference))}


def verdict(reference, test, tolerance=NATIVE):
    return judge(measured_on(reference, test), tolerance, NATIVE)


def broken(reference, test, tolerance=NATIVE):
    return {gate.name for gate in verdict(reference, test, tolerance)[2] if not gate.holds}


def test_a_picture_agrees_with_itself(planes):
    assert verdict(planes, changed(planes))[0] == "agrees"


def test_rounding_to_single_precision_agrees(planes):
    rounded = {k: v.astype(np.float32).astype(float) if v.dtype == float else v for k, v in planes.items()}
    assert verdict(planes, rounded)[0] == "agrees"


def test_a_hole_of_nine_pixels_differs(planes):
    # mean scores forgive it: 9 of 4096 pixels
    hole = changed(planes)
    hole["index"][31:34, 31:34] = -1
    hole["t"][31:34, 31:34] = np.inf
    hole["color"][31:34, 31:34] = 0
    assert broken(planes, hole, MESH) == {"differing pixels"}
    assert "9 in object" in verdict(planes, hole, MESH)[1]


def test_red_two_percent_brighter_differs(planes):
    assert "color p99" in broken(planes, changed(planes, color=planes["color"] * [1.02, 1, 1]), MESH)


def test_a_shift_by_one_pixel_differs(planes):
    shifted = {k: np.roll(v, 1, axis=1) if v.ndim > 1 else v for k, v in planes.items()}
    assert {"color p99", "depth p99", "differing pixels"} <= broken(planes, shifted, MESH)


@pytest.mark.parametrize("plane, word", [("color", "color"), ("t", "distance"), ("position", "position"), ("normal", "normal"),
                                         ("index", "object"), ("depth", "generation")])
def test_one_interior_pixel_differs_in_any_plane(planes, plane, word):
    test = changed(planes)
    test[plane][32, 32] += 1 if plane in ("index", "depth") else 1e-4
    assert broken(planes, test, MESH) == {"differing pixels"}
    assert f"differing pixels is 1 (1 in {word})" in verdict(planes, test, MESH)[1]


def test_a_mesh_beside_exact_shapes_does_not_relax_them(planes):
    """Half of the picture is a mesh's: what is allowed there is none of the other half's business."""
    loose = limits(planes)
    loose.touched[:, SIDE // 2:] = True
    off = changed(planes, color=planes["color"] + 3e-6)
    found = {**metrics.geometry(planes, off), **metrics.picture(planes, off), **apart(planes, off, loose)}
    assert {gate.name for gate in judge(found, MESH, NATIVE)[2] if not gate.holds} == {"color p99, exact shapes"}


@pytest.mark.parametrize("poison", [np.nan, np.inf, -np.inf])
def test_one_value_that_is_not_finite_differs(planes, poison):
    color = planes["color"].copy()
    color[5, 5, 1] = poison  # in the black background
    assert "not finite" in broken(planes, changed(planes, color=color), MESH)


def test_another_object_at_the_same_depth_differs(planes):
    index = planes["index"].copy()
    index[index == 0] = 1
    assert "differing pixels" in broken(planes, changed(planes, index=index), MESH)


def test_a_difference_below_single_precision_is_seen():
    # two buffers 1e-12 apart must not count as equal
    a, b = np.zeros((2, 2, 3)), np.full((2, 2, 3), 1e-12)
    assert np.all(metrics.pixel_error(a, b) == 1e-12)


def test_interior_is_what_its_name_says(planes):
    inner = metrics.interior(planes)
    hit = planes["index"] == 0
    view = planes["position"] / np.linalg.norm(planes["position"], axis=-1, keepdims=True)
    cosine = np.abs(np.sum(view * planes["normal"], axis=-1))
    for row, col in np.argwhere(inner):
        around = np.s_[max(row - 1, 0):row + 2, max(col - 1, 0):col + 2]
        assert hit[around].all() or not hit[around].any()
        assert not hit[row, col] or (cosine[around] > GRAZING).all()
    assert 0.5 < inner.mean() < 1


def test_worst_pixels_come_largest_first_and_nan_before_all_one_a_cluster():
    error = np.zeros((40, 40))
    error[0, 13], error[0, 0], error[39, 39], error[20, 13] = np.nan, 0.5, 0.25, 0.75
    error[0, 25], error[12, 1], error[20, 12], error[39, 27] = 9.0, 9.0, 0.7, 0.2  # within 12 of a worse one in both directions
    assert [(w["row"], w["col"]) for w in metrics.worst_pixels(error)] == [(0, 13), (20, 13), (0, 0), (39, 39)]
    error[39, 26] = 0.2  # 13 columns away: a cluster of its own
    assert [(w["row"], w["col"]) for w in metrics.worst_pixels(error)][-1] == (39, 26)
    assert len(metrics.worst_pixels(np.ones((200, 200)))) == metrics.WORST
    assert metrics.worst_pixels(np.zeros((3, 3))) == []


def test_scores_of_known_pictures():
    # a constant difference d on all channels: MSE = d^2, PSNR = -20 log10 d
    a = np.full((16, 16, 3), 0.5)
    measured = metrics.picture({"color": a}, {"color": a + 0.1})
    assert measured["MSE"] == pytest.approx(0.01)
    assert measured["PSNR"] == pytest.approx(20.0)
    assert measured["SSIM"] < 1 and measured["FLIP mean"] > 0
    same = metrics.picture({"color": a}, {"color": a})
    assert same["SSIM"] == pytest.approx(1) and same["FLIP mean"] == 0 and same["PSNR"] is None


def test_normals_are_compared_by_angle(planes):
    angle = np.radians(1.0)
    turn = np.array([[np.cos(angle), 0, np.sin(angle)], [0, 1, 0], [-np.sin(angle), 0, np.cos(angle)]])
    measured = metrics.geometry(planes, changed(planes, normal=planes["normal"] @ turn.T))
    # a turn by 1 degree moves normals by at most 1 degree, by exactly that where they are square to the axis
    assert measured["normal max degrees"] == pytest.approx(1.0, rel=1e-3)


def test_nothing_measured_where_something_should_have_been_does_not_hold(planes):
    measured = measured_on(planes, planes)
    assert judge(measured, NATIVE, NATIVE)[0] == "agrees"
    for name in ("depth p99", "color p99", "differing pixels", "excused pixels", "unforeseen pixels", "undecided pixels"):
        verdict_, reason, _ = judge({**measured, name: None}, NATIVE, NATIVE)
        assert verdict_ == "differs" and f"{name} is nothing" in reason
    assert judge({**measured, "depth p99": None, "interior hit pixels": 0}, NATIVE, NATIVE)[0] == "agrees"  # nothing is hit


def test_a_truth_that_leaves_more_open_than_rounding_explains_judges_nobody(planes):
    status = planes["status"].copy()
    status[20, 20] = UNDECIDED
    assert broken({**planes, "status": status}, planes) == {"undecided pixels"}


def test_every_limit_says_where_it_comes_from():
    limits = list(tolerances.table())
    assert len({limit.name for limit in limits}) == len(limits) >= 20
    numbers = {value for tolerance in vars(tolerances).values() if isinstance(tolerance, tolerances.Tolerance)
               for value in astuple(tolerance)[2:]}
    single = {getattr(tolerances, name) for name in (
        "REPEATED", "ANALYTICAL", "NUMERICAL", "STEPS_OF_NORMALS", "NUMERICAL_NORMALS", "PROBES", "SAFETY", "ORIGIN_UNITS",
        "DIRECTION_UNITS", "FLOOR_UNITS")}
    assert numbers | single == {limit.value for limit in limits}
    assert all(limit.unit and limit.by for limit in limits)


@pytest.mark.parametrize("facts, proves", [({}, True), ({"measured_mesh_error": 0.0}, True),
                                           ({"measured_mesh_error": 1e-4}, True), ({"measured_mesh_error": None}, False)])
def test_a_mesh_of_unknown_error_proves_nothing(facts, proves):
    run = Run(key="", scene="ball", renderer="embree", title="Embree", state="ok", facts=facts, command="")
    assert (unmeasured(run) == "") == proves


def test_a_scene_that_may_be_another_one_is_told():
    run = Run(key="", scene="ball", renderer="povray", title="POV-Ray", state="ok", facts={"not proven": "a ball may hide a light"}, command="")
    assert "a ball may hide a light" in unproven(run) and unproven(run.model_copy(update={"facts": {"not proven": ""}})) == ""


@pytest.mark.parametrize("verdict, facts, told", [
    ("agrees", {}, "agrees"), ("differs", {}, "differs"), ("expected", {}, "expected"),
    ("agrees", {"measured_mesh_error": None}, "not compared"), ("differs", {"measured_mesh_error": None}, "differs"),
    ("differs", {"not proven": "a ball may hide a light"}, "not compared"), ("agrees", {"not proven": "a ball may hide a light"}, "agrees")])
def test_a_verdict_tells_no_more_than_is_known_of_its_runs(verdict, facts, told):
    run = Run(key="", scene="ball", renderer="any", title="Any", state="ok", facts=facts, command="")
    for runs in ((run,), (run.model_copy(update={"facts": {}}), run)):
        found, reason = concluded(verdict, "20 pixels differ", *runs)
        assert found == told and ("a ball may hide a light" in reason) == (verdict == "differs" and "not proven" in facts)
