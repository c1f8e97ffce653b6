"""What check-port asks and how it judges: right ports pass, one scene's truth fails as another's, mutants are named."""

import json
import sys
import time
from pathlib import Path

import numpy as np
import pytest
import wrong_ports

from raytruth.cli import main
from raytruth.comparisons.bench import port as cpp
from raytruth.comparisons.ports import cases as all_cases
from raytruth.comparisons.ports import check, vectors
from raytruth.comparisons.ports.cases import Case, chosen, small
from raytruth.comparisons.ports.document import Check
from raytruth.comparisons.ports.mistakes import SWITCHES
from raytruth.comparisons.ports.protocol import Reply
from raytruth.comparisons.ports.session import Port
from raytruth.comparisons.ports.truth import Truths
from raytruth.comparisons.suites import head
from raytruth.reference_tracer.errors import InputError, MissingError
from raytruth.reference_tracer.oracle.literal import LiteralSearch, point_color
from raytruth.reference_tracer.scene import library

NUMPY = [sys.executable, str(wrong_ports.NUMPY_SOURCE)]
SOON = ["algorithm:surfaces", "algorithm:events", "algorithm:switches", "algorithm:pictures"]


@pytest.fixture(scope="module")
def truths(tmp_path_factory):
    return Truths(tmp_path_factory.mktemp("truths"))


def checked(command, cases, truths, seconds=300.0):
    start = time.monotonic()
    with Port(command) as port:
        declared = port.greet(60)
        results = check.check(port, declared, cases, truths, seconds)
    return Check(**head(start), command=command, port=declared, results=results)


def test_ids_keep_their_meaning():
    asked = [question for group in vectors.groups() for question in group.questions()]
    assert len(dict(asked)) == len(asked)
    given = vectors.listed()
    for id, checksum in asked:
        assert given.get(id) == checksum, f"{id} asks something else than when it was given away: give it a new id"


def test_every_flag_is_explained_and_every_decision_known():
    decisions = Path("reference_tracer/DECISIONS.md").read_text(encoding="utf-8")
    for group in vectors.groups():
        assert all(f"| {id} |" in decisions for id in group.decisions), group.id
        assert set(group.flags).union(*(v.flags for v in group.vectors)) <= set(vectors.FLAGS)
        assert all(abs(np.linalg.norm(v.d) - 1) < 1e-15 for v in group.vectors)


@pytest.mark.parametrize("name", ["surfaces/torus-turned", "events/refraction", "events/shadow", "switches/as-in-the-figures"])
def test_given_rays_are_traced_as_the_oracle_traces_them(name, truths):
    case, = chosen([f"algorithm:{name}"])
    o, d = case.rays.o, case.rays.d
    search = LiteralSearch(case.scene)
    inside = search._signs(o, d, np.zeros(len(d)))
    color = point_color(case.scene, search, o, d, inside, np.full(len(d), case.scene.tracing.max_distance), 0)
    assert np.abs(truths.planes(case)["color"][0] - color).max() < 1e-9


@pytest.mark.parametrize("command", [NUMPY, "cpp"], ids=["NumPy", "C++"])
def test_a_right_port_passes(command, truths):
    if command == "cpp":
        try:
            command = [str(cpp.build()), "--serve"]
        except MissingError as error:
            pytest.skip(str(error))
    found = checked(command, chosen([*SOON, "algorithm:scenes/effect-mixing"]), truths)
    assert {r.verdict for r in found.results} == {"pass"}, [r for r in found.results if r.verdict != "pass"]
    assert found.holds


def test_the_truth_of_a_scene_fails_as_that_of_every_other(truths):
    size = (16, 12)
    named = {name: Case(name, "model", library.scene(name).resized(*size, samples=1), "7")
             for name in ("effect-shading", "effect-shadow", "figure-05-sphere", "figure-06-ellipsoid",
                          "figure-10-refraction-n0.8", "figure-12-refraction-n1.0")}
    answers = {name: Reply({plane: truths.planes(case)[plane] for plane in ("color", "t", "normal")})
               for name, case in named.items()}
    for name, case in named.items():
        for other, answer in answers.items():
            verdict = check.judged(case, answer, 64, truths).verdict
            assert verdict == ("pass" if name == other else "fail"), (name, other)


def test_rounding_is_forgiven_and_a_little_more_is_not(truths):
    case = Case("sphere", "model", small(library.scene("figure-05-sphere")), "7")
    planes = {name: truths.planes(case)[name] for name in ("color", "index", "t", "normal")}
    off = lambda by: Reply({**planes, "color": planes["color"] + by})
    assert check.judged(case, off(5e-10), 64, truths).verdict == "pass"
    failed = check.judged(case, off(1e-6), 64, truths)
    assert failed.verdict == "fail" and failed.plane == "color" and failed.got[0] - failed.expected[0] == pytest.approx(1e-6)
    assert check.judged(case, off(1e-6), 32, truths).verdict == "pass"
    missing = Reply({**planes, "index": np.where(planes["index"] == 0, -1, planes["index"])})
    assert check.judged(case, missing, 64, truths).stage == "hit"


def test_what_a_port_does_not_claim_is_skipped_and_counts(truths):
    case, = chosen(["algorithm:events/refraction"])
    with Port(NUMPY) as port:
        declared = replace_words(port.greet(60), surfaces=("sphere",), effects=())
        result, = check.check(port, declared, [case], truths, 60)
    assert result.verdict == "skipped" and "surface plane, effect refraction, effect shadow" in result.message


def replace_words(declared, **words):
    return declared.model_copy(update=words)


def test_a_case_says_what_it_needs():
    needs = {case.id: case.needs for case in all_cases.cases()}
    assert needs["algorithm:surfaces/sphere"] == {"surface": {"sphere"}, "effect": set(), "switch": set()}
    assert needs["model:switches/misprint"]["switch"] == {"E1"}
    assert needs["model:pictures/oblique"]["switch"] == {"F5"}
    with pytest.raises(InputError, match="no case 'nonsense'"):
        chosen(["nonsense"])


def test_the_command_line_lists_repeats_and_exits(capsys, tmp_path):
    run = lambda *words: (main(["check-port", "-o", str(tmp_path), *words, "--", *NUMPY]), capsys.readouterr().out)
    code, out = run("--list")
    assert code == 0 and "run   algorithm:surfaces/plane" in out and "69 of 69 cases will run" in out
    code, out = run("--only", "algorithm:surfaces/sphere", "--history", "3")
    assert code == 0 and "1 of 1 cases hold" in out and "reference: 0 camera" in out and "the port: 0 camera" in out
    assert json.loads((tmp_path / "check-port.json").read_text())["results"][0]["verdict"] == "pass"


def test_a_port_may_draw_pictures_only(capsys, tmp_path):
    program = tmp_path / "draw.py"
    program.write_text(f"import sys\nsys.path.insert(0, {str(wrong_ports.NUMPY_SOURCE.parent)!r})\nimport numpy, tracer\n"
                       "color = tracer.answer(tracer.Scene(open(sys.argv[1]).read()))['color'][0]\nnumpy.save(sys.argv[2], color)\n")
    code = main(["check-port", "-o", str(tmp_path), "--only", "pictures", "--image-only", "--scenes", "text", "--pictures",
                 ".npy", "--level", "algorithm", "--precision", "64", "--", sys.executable, str(program)])
    assert code == 0 and "5 of 5 cases hold" in capsys.readouterr().out
    program.write_text("import sys\nopen(sys.argv[2], 'w').write('<html>')\n")
    code = main(["check-port", "-o", str(tmp_path), "--only", "pictures/turned", "--image-only", "--pictures", ".npy",
                 "--level", "algorithm", "--", sys.executable, str(program)])
    assert code == 1 and "malformed" in capsys.readouterr().out


# --- one classic mistake each ----------------------------------------------------------------------------------------------
TELLING = ["algorithm:events", "algorithm:pictures", "algorithm:surfaces/heart", "algorithm:scenes/effect",
           "algorithm:scenes/figure-05-sphere"]


@pytest.fixture
def command(request, tmp_path):
    """Of a wrong port: the ids of C++ mistakes, or the name of a NumPy one."""
    try:
        return wrong_ports.wrong_numpy(request.param, tmp_path) if isinstance(request.param, str) else \
            wrong_ports.serving(*request.param)
    except MissingError as error:
        pytest.skip(str(error))


@pytest.mark.parametrize("command", [*((id,) for id in wrong_ports.IDS), *wrong_ports.NUMPY], indirect=True, ids=str)
def test_a_classic_mistake_is_failed(command, truths):
    with Port(command) as port:
        declared = port.greet(60)
        assert any(check.asked(port, declared, case, truths, 300).verdict in ("fail", "non-finite")
                   for case in chosen(TELLING))


@pytest.mark.parametrize("command, ids, cases", [
    ("blue first", ["blue-first"], ["scenes/effect-shading"]),
    (("rows-from-the-bottom",), ["rows-from-the-bottom"], ["pictures/landscape"]),
    (("snell-as-printed",), ["snell-as-printed"], ["events/refraction"]),
    (("total-reflection-weighs-r",), ["total-reflection-weighs-r"], ["events/total-with-mirror", "events/leaving"]),
    (("single-precision",), ["single-precision"], ["scenes/effect-shading"]),
    (("eight-bits",), ["eight-bits"], ["scenes/effect-shading"]),
    (SWITCHES, SWITCHES, [*TELLING, "algorithm:surfaces/heart"])], indirect=["command"], ids=str)
def test_mistakes_are_named(command, ids, cases, truths):
    kept = []
    with Port(command) as port:
        check.check(port, port.greet(60), chosen([f"algorithm:{case.removeprefix('algorithm:')}" for case in cases]), truths, 300,
                    kept=kept)
    assert {cause.id for cause in check.likely(kept, 64, truths)} == set(ids)
