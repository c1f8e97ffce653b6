"""Speed against accuracy: what counts as wrong, what is counted, the frontier, and the sentences."""

import numpy as np
import pytest

from raytruth.comparisons.bench.document import Spread
from raytruth.comparisons.charting.cases import FORMULAS, surface
from raytruth.comparisons.charting.competitors import Ours, competitor
from raytruth.comparisons.charting.document import Accuracy, Point, Series, Times, clock, frontier
from raytruth.comparisons.charting.findings import findings
from raytruth.comparisons.charting.measure import interleave
from raytruth.comparisons.charting.truth import OTHER_ROOT, Truth, accuracy, make, uncertainty
from raytruth.reference_tracer.errors import UnsupportedError
from raytruth.reference_tracer.scene.model import Camera, Object, Scene, Tracing
from raytruth.reference_tracer.surfaces.expression import Expression
from raytruth.reference_tracer.surfaces.sphere import Sphere

SHAPE = 10, 20


def truth() -> Truth:
    """A plane at depth 4 before everything; the first row judges nobody."""
    decided = np.ones(SHAPE, bool)
    decided[0] = False
    return Truth(np.full((*SHAPE, 3), 0.5), np.full(SHAPE, 4.0), np.zeros(SHAPE, int), decided, 3,
                 np.full(SHAPE, 1e-12), np.full(SHAPE, 1e-14))


def planes() -> dict:
    return {"color": np.full((*SHAPE, 3), 0.5), "t": np.full(SHAPE, 4.0), "index": np.zeros(SHAPE, int),
            "status": np.ones(SHAPE, int)}


def test_the_truth_itself_has_no_error():
    a = accuracy(truth(), planes())
    assert (a.pixels, a.wrong, a.depth_p99, a.depth_max, a.color_p99, a.color_max) == (180, 0, 0, 0, 0, 0)


def test_every_kind_of_wrong_pixel_is_counted_once_and_undecided_ones_are_not():
    p = planes()
    p["index"][3, 3] = -1  # missed
    p["index"][3, 4] = 1  # another object
    p["t"][3, 5] = 4 * (1 + 1.01 * OTHER_ROOT)  # another root
    p["t"][3, 6] = np.nan
    p["color"][3, 7, 1] = np.nan
    p["index"][3, 3], p["color"][3, 3] = -1, np.nan  # two faults in one pixel
    p["index"][0] = 9  # does not judge
    p["status"][5, :4] = 2
    a = accuracy(truth(), p)
    assert (a.wrong, a.undecided) == (5, 4)
    assert a.depth_max == 0  # errors of wrong pixels are not errors of depth


def test_errors_of_depth_and_colour_are_those_put_in():
    p = planes()
    p["t"][4, 4] += 4 * 1e-3
    p["color"][4, 5, 2] -= 0.25
    p["color"][4, 6, 0] += 0.003  # less than 1/255
    a = accuracy(truth(), p)
    assert (a.wrong, a.visible) == (0, 1)
    assert a.depth_max == pytest.approx(1e-3) and a.color_max == pytest.approx(0.25)
    assert a.depth_p99 == 0  # one pixel of 180 is less than a hundredth


def test_no_right_pixel_means_no_depth():
    p = planes()
    p["index"][:] = -1
    assert accuracy(truth(), p).depth_max is None


def test_uncertainty_speaks_of_pixels_that_judge():
    t = truth()
    t.color_bound[0] = 1.0
    assert uncertainty(t).color_max == 1e-12 and uncertainty(t).depth_p99 == 1e-14


def test_an_edge_that_rounding_moves_judges_nobody():
    """The camera's middle column of rays runs exactly within the face x = 0 of a slab: rounding decides."""
    slab = Expression(type="expression", center=(0.0, 0.0, 5.0), formula="abs(x - 1) - 1")
    scene = Scene(camera=Camera(width=5, height=5, fov=30.0), objects=(Object(surface=slab),))
    decided = make(scene).decided
    assert not decided[:, 2].any() and decided[:, 0].all()


def test_evaluations_are_counted_as_the_literal_method_makes_them():
    """Nothing is ever hit and no box ends a ray: exactly max_distance / h samples."""
    never = Expression(type="expression", center=(0.0, 0.0, 0.0), formula="x**4 + y**4 + z**4 + 1")
    scene = Scene(camera=Camera(width=8, height=6), objects=(Object(surface=never),),
                  tracing=Tracing(max_distance=10.0))
    assert Ours(scene, "paper", step_size=0.1).evaluations() == 100
    assert Ours(scene, "paper", step_size=0.05).evaluations() == 200
    two = scene.model_copy(update={"objects": scene.objects * 2})
    assert Ours(two, "paper", step_size=0.1).evaluations() == 200


def test_a_closed_form_takes_f_equally_often_for_every_ray():
    """Its count is one literal for all rays, which must not be counted as that of one ray."""
    ball = Object(surface=Sphere(type="sphere", center=(0.0, 0.0, 4.0), r=1.0))
    scene = Scene(camera=Camera(width=8, height=6), objects=(ball,))
    count = Ours(scene, "exact").evaluations()
    assert count >= 1 and count == round(count)
    assert Ours(scene.model_copy(update={"objects": (ball, ball)}), "exact").evaluations() == 2 * count


def test_descartes_does_not_lend_its_name_to_intervals():
    blob, shell = (surface(name).resized(8, 6) for name in ("surface-blob", "surface-thin-shell"))
    ask = lambda scene: competitor(scene, "reference", {"method": "descartes"}, {}, None, None)
    with pytest.raises(UnsupportedError, match="algebraic"):
        ask(blob)
    assert ask(shell).method == "descartes"


def test_single_surfaces_cross_the_axis_where_their_formulas_say():
    """The thin shell's outer face lies at radius sqrt(1.01): the proof must find it from 3 away."""
    t = make(surface("surface-thin-shell").resized(9, 9))
    assert t.t[4, 4] == pytest.approx(3 - 1.01**0.5, abs=1e-12)
    assert all(surface(name).name == name for name in FORMULAS)


def test_the_frontier_is_what_nothing_beats():
    points = [(1, 9), (2, 5), (2, 7), (3, 5), (4, 1), (5, 0), (6, 0), (0.5, 20)]
    assert frontier(points) == [(0.5, 20), (1, 9), (2, 5), (4, 1), (5, 0)]
    assert frontier([]) == []


def test_turns_are_interleaved_and_one_that_fails_is_not_asked_again():
    asked = []

    def contestant(name, fails):
        def ask():
            asked.append(name)
            return {"state": "crashed", "message": "gone"} if fails else {"state": "ok", "facts": {
                "wall": float(len(asked)), "cpu": 1.0, "others": 0.5, "seconds": 1.0}}
        return ask

    timed = interleave({"a": contestant("a", False), "b": contestant("b", True), "c": contestant("c", False)}, 3)
    assert asked == ["a", "b", "c", "a", "c", "a", "c"]
    assert timed["a"].times().wall == Spread(median=4, low=1, high=6)
    assert timed["b"].times() is None and timed["b"].failure["message"] == "gone"
    assert timed["a"].others == 0.5 and timed["a"].build is None


def test_the_processor_decides_on_a_busy_machine():
    assert clock([]) == clock([0.01, 0.02]) == "wall"
    assert clock([0.0, 1.5]) == "cpu"


def point(wrong, seconds, value=None, evaluations=None, build=None) -> Point:
    spread = lambda s: Spread(median=s, low=s, high=s)
    times = Times(wall=spread(seconds), cpu=spread(10 * seconds))
    return Point(label="" if value is None else f"h {value:g}", value=value, settings={}, state="ok", picture=times,
                 hits=times, build=build and spread(build), evaluations=evaluations,
                 accuracy=Accuracy(pixels=1000, wrong=wrong, visible=wrong, depth_p99=0, depth_max=0, color_p99=0,
                                   color_max=0, undecided=0))


def series(id, *points, kind="first hits") -> Series:
    return Series(id=id, method=id, title=id, kind=kind, parameter="h", points=list(points))


def test_findings_compare_what_reaches_zero_wrong_pixels():
    steps = series("paper", point(40, 1, 0.1, 50), point(0, 8, 0.01, 400), point(0, 20, 0.005, 800))
    exact, proof = series("exact", point(0, 0.5, None, 10)), series("proof", point(0, 2, None, 5))
    mesh = series("mesh", point(200, 0.1, 32, build=0.1), point(7, 0.5, 64, build=2), kind="converter")
    told = findings([steps, exact, proof, mesh], "wall")
    assert "cheapest method is exact: first hits cost 16 times less" in told[0] and "gets there, 0.01" in told[0]
    assert "cheapest method is proof: it evaluates f 80 times less" in told[1]
    assert "zero visibly wrong pixels" in told[2] and "the whole picture costs 16 times less" in told[2]
    assert "mesh at h 64" in told[3] and "it takes 5 times as long as exact" in told[3]  # (0.5 + 2) / 0.5


def test_findings_say_when_no_step_gets_there():
    steps = series("paper", point(40, 1, 0.1), point(3, 8, 0.01))
    told = findings([steps, series("exact", point(0, 0.5))], "wall")
    assert "step 0.01, which still leaves 3 of 1000 pixels wrong" in told[0]
    assert not findings([steps], "wall")


def test_an_oracle_with_an_error_is_a_broken_measurement():
    broken = series("oracle", point(1, 1), kind="control")
    assert any("measurement is broken" in told for told in findings([broken], "wall"))
    assert not findings([series("oracle", point(0, 1), kind="control")], "wall")


