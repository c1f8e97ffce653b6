"""The suite: a renderer that crashes, hangs or writes garbage costs its own cases; finished work is reused."""

import dataclasses
import json
import os
import sys
import textwrap

import pytest
from workers import child

from raytruth.comparisons import renderers, suite
from raytruth.comparisons.execution import pool
from raytruth.comparisons.execution.pool import Pool
from raytruth.comparisons.execution.process import Worker
from raytruth.comparisons.results import read
from raytruth.comparisons.runs import Request, RunStore
from raytruth.reference_tracer.errors import InputError
from raytruth.reference_tracer.scene.load import parse_scene

SCENE = parse_scene(json.dumps({
    "name": "ball", "camera": {"width": 24, "height": 16},
    "objects": [{"surface": {"type": "sphere", "center": [0, 0, 3], "r": 1}}],
    "lights": [{"position": [2, 2, 0]}]}).encode())


@pytest.mark.parametrize("body, state, word", [
    ("os.kill(os.getpid(), signal.SIGABRT)", "crashed", "SIGABRT"),
    ("sys.exit('out of luck')", "crashed", "out of luck"),
    ("os.close(1); time.sleep(60)", "crashed", "closed its output"),
    ("time.sleep(60)", "timeout", "0.6 s"),
    ("sys.stdout.write('{\"state\":'); time.sleep(60)", "timeout", "0.6 s"),
    ("print('GARBAGE')", "malformed", "GARBAGE"),
    ("print('[1, 2]')", "malformed", "not an answer"),
    ("print(json.dumps({'state': 'splendid'}))", "malformed", "splendid"),
])
def test_a_broken_worker_is_named_by_its_fault(body, state, word):
    with Worker(child(body)) as worker:
        answer = worker.ask({}, limit=0.6 if state == "timeout" else 20)
    assert answer["state"] == state and word in answer["message"]


def test_a_worker_is_replaced_after_its_crash():
    with Worker(child("""
        if request["crash"]:
            os.kill(os.getpid(), signal.SIGSEGV)
        print(json.dumps({"state": "ok"}))
        """)) as worker:
        assert worker.ask({"crash": False}, 20)["state"] == "ok"
        assert worker.ask({"crash": True}, 20)["state"] == "crashed"
        assert worker.ask({"crash": False}, 20)["state"] == "ok"


def test_an_endless_answer_is_cut_off():
    with Worker(child("while True: sys.stdout.write('x' * 65536)")) as worker:
        assert worker.ask({}, limit=20)["state"] == "crashed"


@pytest.mark.parametrize("write, word", [
    ("open(arguments['planes'], 'wb').write(b'rubbish')", "cannot be read"),
    ("pass", "left no planes"),
    ("np.savez(open(arguments['planes'], 'wb'), **{k: np.zeros((2, 2, 3)) for k in names}, metadata='{}')", "2 x 2"),
])
def test_planes_that_are_not_the_picture_are_malformed(tmp_path, monkeypatch, write, word):
    monkeypatch.setattr(pool, "COMMAND", child(f"""
        names = ("color", "t", "position", "normal", "index", "depth", "status")
        {write}
        print(json.dumps({{"state": "ok", "facts": {{}}}}))
        """))
    with Pool(1) as made:
        run = RunStore(tmp_path).make(Request(SCENE, "exact"), made, 20)
    assert run.state == "malformed" and word in run.message and run.planes is None


class Asked(pool.Silent):
    """Notes every case that a worker is asked for."""

    def __init__(self):
        self.labels = []

    def end(self, label, seconds, state):
        self.labels.append(label)


def test_a_crash_costs_its_own_case_and_the_rest_is_kept(tmp_path, monkeypatch):
    sound = pool.COMMAND
    # the renderer "paper" dies like a fatal kernel does: without a chance to say anything
    monkeypatch.setattr(pool, "COMMAND", (sys.executable, "-c", textwrap.dedent("""
        import os
        from raytruth.comparisons.execution import worker
        answer = worker.answer
        worker.answer = lambda request: os.abort() if request["arguments"].get("renderer") == "paper" else answer(request)
        worker.main()
        """)))
    options = suite.Options(tmp_path, renderers=("paper", "mitsuba-native"), with_studies=False)
    results = suite.compare([SCENE], options)
    verdicts = {c.id: c.verdict for c in results.comparisons}
    assert verdicts == {"ball--paper": "not compared", "ball--mitsuba-native": "agrees"}
    assert [r.state for r in results.runs if r.renderer == "paper"] == ["crashed"]
    assert read(tmp_path) == results

    # with a sound worker the suite resumes: it makes what is missing and nothing else
    monkeypatch.setattr(pool, "COMMAND", sound)
    asked = Asked()
    options = dataclasses.replace(options, progress=asked)
    results = suite.compare([SCENE], options)
    assert sorted(asked.labels) == ["exact and paper: ball", "paper and mitsuba-native: ball", "paper: ball",
                                    "rays: ball, paper"]
    assert all(c.verdict != "not compared" for c in results.comparisons)

    # and an unchanged suite makes nothing and leaves the document alone
    before = os.stat(tmp_path / "results.json").st_mtime_ns
    asked.labels.clear()
    assert suite.compare([SCENE], options).comparisons == results.comparisons
    assert not asked.labels and os.stat(tmp_path / "results.json").st_mtime_ns == before


def test_every_change_of_scene_or_settings_is_another_run():
    one = Request(SCENE, "exact")
    others = [Request(SCENE.resized(25, 16), "exact"), Request(SCENE, "paper"), Request(SCENE, "exact", {"precision": 32}),
              Request(SCENE.traced_with(refraction="as_printed"), "exact")]
    assert len({one.key, *(r.key for r in others)}) == 5
    assert Request(SCENE.model_copy(update={"title": "other words"}), "exact").key == one.key


def test_native_shapes_of_a_scene_without_any_are_not_applicable(tmp_path):
    torus = json.loads(SCENE.model_dump_json(by_alias=True, exclude_none=True))
    torus["objects"][0]["surface"] = {"type": "torus", "center": [0, 0, 3], "R": 1, "r": 0.3}
    options = suite.Options(tmp_path, renderers=("mitsuba-native",), with_studies=False)
    comparison, = suite.compare([parse_scene(json.dumps(torus).encode())], options).comparisons
    assert comparison.verdict == "not compared" and "not applicable" in comparison.reason


def test_an_unknown_renderer_is_one_sentence():
    with pytest.raises(InputError, match="unknown renderer 'blender'; choose one of exact"):
        renderers.find("blender")
