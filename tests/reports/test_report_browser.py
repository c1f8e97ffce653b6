"""The report in a real browser, from disk: every kind of page is whole, quiet and accessible, and the viewer tells the truth.

The browser is the system's Chromium, driven by Playwright; where there is none these tests are skipped and say so.
"""

import re
import shutil
from dataclasses import replace
from importlib.resources import files

import numpy as np
import pytest
import test_report_evidence
import test_report_matrix
import test_report_plan
import test_report_speed
import test_report_stability
import test_report_transport
from report_support import ERROR_AT, HEIGHT, NAN_AT, UNDECIDED_AT, WIDTH, make_folder, make_results

from raytruth import reports
from raytruth.comparisons import document
from raytruth.comparisons import results as documents
from raytruth.comparisons.agreement import records
from raytruth.comparisons.attribution import document as attribution
from raytruth.comparisons.charting import document as charting
from raytruth.comparisons.execution import store
from raytruth.comparisons.planning import document as planning
from raytruth.comparisons.stability import document as stability
from raytruth.comparisons.transport import document as transport
from raytruth.comparisons.verdicts.metrics import pixel_error, worst_pixels
from raytruth.reference_tracer.scene import library
from raytruth.reference_tracer.tracer.image_files import to_8_bit

pytestmark = pytest.mark.slow
CHROMIUM = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None)
SCENE = "scenes/figure-05-sphere.html"
ROW, COL = 12, 12  # where a channel is not finite
FAR = (22, 30)  # the worst pixel of another cluster
KINDS = ("index.html", "reading.html", "trust.html", SCENE, "matrix.html", "evidence.html", "evidence/shadow.html",
         "transport.html", "effects.html", "decisions.html", "stability.html", "speed.html", "speed/figure-05-sphere.html",
         "plan.html")


@pytest.fixture(scope="module")
def pictures(pictures):
    """Those of all tests; the bad one has an error of 1/4 far from its others."""
    bad = replace(pictures["bad"], color=pictures["bad"].color.copy())
    bad.color[FAR] += 0.25
    return {**pictures, "bad": bad}


@pytest.fixture(scope="module")
def site(tmp_path_factory, pictures):
    """A report with every kind of page."""
    folder = make_folder(tmp_path_factory.mktemp("browser") / "results", pictures)
    results = make_results(pictures["good"].scene)
    shadow = results.scenes[0].model_copy(update={"name": "effect-shadow"})
    worst = worst_pixels(pixel_error(pictures["good"].color, pictures["bad"].color))
    pixel = test_report_evidence.attribution().pixels[0].model_copy(update={"row": ROW, "col": COL})
    comparisons = [c.model_copy(update={"worst": worst, "histories": [pixel]}) if c.id == "faulty" else c
                   for c in results.comparisons]
    documents.write(results.model_copy(update={"scenes": [*results.scenes, shadow], "comparisons": comparisons}), folder)
    records.write(test_report_matrix.document(), folder)
    document.write(test_report_evidence.table(test_report_evidence.fault(test_report_evidence.judged(True, "shadow"))),
                   folder / attribution.FILE)
    test_report_transport.planes(folder / "transport" / "whole.npz")
    transport.keep(transport.Transport(created="c", seconds=1, machine=results.machine,
                                       cases=[test_report_transport.record("whole")]), folder)
    family = test_report_stability.family(laws=[test_report_stability.law()], steps=test_report_stability.STEPS,
                                          sure=test_report_stability.GOOD)
    document.write(test_report_stability.document(family), folder / stability.FILE)
    document.write(test_report_speed.make_chart(*test_report_speed.ALL), folder / charting.FILE)
    plan = test_report_plan.make_plan("ball").model_copy(update={"planes": f"{planning.PLANES}/ball.npz"})
    shape = test_report_plan.HEIGHT, test_report_plan.WIDTH
    store.save(folder / plan.planes, color=to_8_bit(np.full((*shape, 3), 0.5)), change=np.zeros(shape))
    planning.add(plan, folder)
    return reports.build(folder, tmp_path_factory.mktemp("browser") / "html").parent


@pytest.fixture(scope="module")
def browser():
    if CHROMIUM is None:
        pytest.skip("no Chromium on this machine: install the package chromium")
    from playwright.sync_api import sync_playwright

    with sync_playwright() as playwright:
        opened = playwright.chromium.launch(executable_path=CHROMIUM, args=["--no-sandbox"])
        yield opened
        opened.close()


@pytest.fixture
def visit(browser, site):
    """Opens a page of the report; what it complains of, or asks a network for, is in `page.complaints`."""
    contexts = []

    def go(path: str, width: int = 1400, **options):
        contexts.append(browser.new_context(viewport={"width": width, "height": 900}, **options))
        page = contexts[-1].new_page()
        page.complaints = []
        page.on("console", lambda m: page.complaints.append(m.text) if m.type in ("error", "warning") else None)
        page.on("pageerror", lambda error: page.complaints.append(str(error)))
        page.on("request", lambda r: None if r.url.startswith(("file://", "blob:", "data:")) else page.complaints.append(r.url))
        page.on("requestfailed", lambda r: page.complaints.append(f"missing {r.url}"))
        page.goto(f"file://{site}/{path}")
        return page

    yield go
    for context in contexts:
        context.close()


SHOW_ALL = """() => Promise.all([...document.images].map((image) => {
  image.loading = "eager";
  return image.complete ? null : new Promise((done) => { image.onload = image.onerror = done; });
})).then(() => [...document.images].filter((image) => image.naturalWidth === 0).map((image) => image.src))"""
WIDER = """() => document.documentElement.scrollWidth - document.documentElement.clientWidth"""


@pytest.mark.parametrize("path", KINDS)
def test_a_page_is_whole_quiet_and_accessible(visit, path):
    axe = files("axe_playwright_python").joinpath("axe.min.js").read_text(encoding="utf-8")
    for width in (1400, 360):
        page = visit(path, width)
        assert page.evaluate(SHOW_ALL) == []
        assert page.evaluate(WIDER) == 0, f"{width} wide"
        page.evaluate(axe)
        for scheme in ("light", "dark"):
            page.emulate_media(color_scheme=scheme)
            found = page.evaluate("() => axe.run(document, {resultTypes: ['violations'], preload: false})")
            assert [(v["id"], v["nodes"][0]["html"][:200], v["nodes"][0]["failureSummary"][:300]) for v in found["violations"]
                    if v["impact"] in ("serious", "critical")] == [], f"{width} wide, {scheme}"
        assert page.complaints == []


@pytest.mark.parametrize("path", KINDS)
def test_a_page_without_scripts_says_the_same(visit, path):
    words = lambda page: set(re.findall(r"\w+", page.inner_text("main")))
    without, with_scripts = visit(path, java_script_enabled=False), visit(path)
    assert without.evaluate(WIDER) == 0 and without.complaints == []
    tools = set(re.findall(r"\w+", " ".join(with_scripts.locator("[data-part=tool], [data-part=filter]").all_inner_texts())))
    assert words(with_scripts) - words(without) - tools == set()
    if path == SCENE:
        assert "need scripts" in without.inner_text("#viewer") and not without.locator("[data-part=canvas]").is_visible()
        assert without.locator("#details img").count() >= 3


def test_the_bar_has_six_entries_at_most_and_says_where_one_is(visit):
    for path in KINDS:
        page = visit(path)
        entries = page.locator("header nav a")
        assert 1 <= entries.count() <= 6
        assert page.locator("header nav [aria-current]").count() == 1
        page.keyboard.press("Tab")
        assert page.evaluate("() => document.activeElement.className") == "skip"


def opened(visit, fragment="#viewer&a=good&b=bad", **options):
    page = visit(SCENE + fragment, **options)
    page.wait_for_selector("#viewer[data-ready='good bad']")
    return page


def cells(page, row: str) -> list[str]:
    return [text.replace("−", "-") for text in page.locator(f"[data-row={row}] td").all_inner_texts()]


def state(page) -> dict[str, str]:
    page.wait_for_function("() => location.hash === document.querySelector('#viewer [data-part=link]').hash")  # it follows
    return dict(re.findall(r"(\w+)=([^&]*)", page.url))


def test_nothing_is_loaded_before_it_is_asked_for_and_then_one_file_a_side(visit, site):
    page = visit(SCENE)
    asked = []
    page.on("request", lambda r: asked.append(r.url))
    assert page.evaluate("() => document.querySelectorAll('script[src*=planes\\\\/]').length") == 0
    size = sum((site / "planes" / f"{name}.js").stat().st_size for name in ("good", "bad"))
    assert f"{size / 1e6:.{2 if size < 1e5 else 1}f} MB" in page.inner_text("[data-part=open]")
    page.click("[data-part=open]")
    page.wait_for_selector("#viewer[data-ready]")
    scripts = sorted(url.rpartition("/")[2] for url in asked if url.endswith(".js"))
    assert scripts == ["bad.js", "good.js"] and page.complaints == []


@pytest.mark.parametrize("place", [*ERROR_AT, NAN_AT, UNDECIDED_AT, (0, 0), (HEIGHT - 1, WIDTH - 1)])
def test_the_readout_is_the_arrays_value_to_the_last_digit(visit, pictures, place):
    page = opened(visit, "#viewer&a=good&b=bad&row={}&col={}".format(*place))
    good, bad = pictures["good"], pictures["bad"]
    for channel, row in enumerate(("red", "green", "blue")):
        for text, picture in zip(cells(page, row), (good, bad)):
            value = picture.color[place][channel]
            assert text == "not a number" if np.isnan(value) else float(text) == value  # == : every digit
    if good.index[place] >= 0:
        assert [float(text) for text in cells(page, "t")[:2]] == [good.t[place], bad.t[place]]
        for k, axis in enumerate("xyz"):
            assert np.float32(float(cells(page, f"normal-{axis}")[0])) == np.float32(good.normal[place][k])
        assert "ball" in cells(page, "object")[0]
    else:
        assert cells(page, "object")[0] == "nothing" and cells(page, "t")[0] == "–"
    assert cells(page, "status")[1] == ("undecided" if place == UNDECIDED_AT else "decided")


def canvas_colour(page, row: int, col: int) -> list[int]:
    """What the canvas shows in the middle of a pixel, the whole picture in view."""
    return page.evaluate("""([row, col, w]) => { const c = document.querySelector("[data-part=canvas]"), s = c.width / w;
        return [...c.getContext("2d").getImageData(Math.floor((col + 0.5) * s), Math.floor((row + 0.5) * s), 1, 1).data]
               .slice(0, 3); }""", [row, col, WIDTH])


def test_both_sides_and_the_error_have_the_colours_of_their_numbers(visit, pictures):
    from raytruth.reports.figures import scale

    page, place = opened(visit), (10, 16)
    expected = {"1": pictures["good"].color[place], "2": pictures["bad"].color[place]}
    page.focus("[data-part=canvas]")
    for key, color in expected.items():
        page.keyboard.press(key)
        assert canvas_colour(page, *place) == to_8_bit(color).tolist()
    page.keyboard.press("4")
    assert canvas_colour(page, *place) == scale.TABLE[scale.level(ERROR_AT[place])].tolist()
    assert canvas_colour(page, *NAN_AT) == scale.NON_FINITE.tolist()
    assert canvas_colour(page, *UNDECIDED_AT) == scale.UNDECIDED.tolist()
    assert canvas_colour(page, 0, 0) == [0, 0, 0]
    page.select_option("[data-part=kind]", "signed")  # B is larger: the same colour; smaller: red and blue change places
    assert canvas_colour(page, *place) == scale.TABLE[scale.level(ERROR_AT[place])].tolist()
    page.select_option("[data-part=a]", "bad")
    page.select_option("[data-part=b]", "good")
    page.wait_for_selector("#viewer[data-ready='bad good']")
    assert canvas_colour(page, *place) == scale.TABLE[scale.level(ERROR_AT[place])].tolist()[::-1]
    page.select_option("[data-part=most]", "0.01")  # 1e-3 is a tenth of the linear scale
    page.select_option("[data-part=kind]", "absolute")
    error = np.abs(pictures["bad"].color - pictures["good"].color)[place].max()
    assert canvas_colour(page, *place) == scale.TABLE[int(error / 0.01 * (scale.LEVELS - 1) + 0.5)].tolist()


def test_exposure_brightens_by_powers_of_two(visit, pictures):
    page = opened(visit)
    place = tuple(np.argwhere((pictures["good"].color.max(-1) > 0.1) & (pictures["good"].color.max(-1) < 0.4))[0])
    page.focus("[data-part=canvas]")
    page.keyboard.press("]")
    page.keyboard.press("]")
    assert canvas_colour(page, *map(int, place)) == to_8_bit(2 * pictures["good"].color[place]).tolist()


def test_switching_keeps_the_place(visit):
    page = opened(visit, "#viewer&a=good&b=bad&row=13&col=16&zoom=6")
    before = state(page)
    page.click("[data-part=flip]")
    flipped = state(page)
    assert (before.pop("view"), flipped.pop("view")) == ("a", "b") and before == flipped
    page.select_option("[data-part=b]", "paper")
    page.wait_for_selector("#viewer[data-ready='good paper']")
    after = state(page)
    assert after.pop("b") == "paper" and before.pop("b") == "bad" and after.pop("view") and after == before


def test_worst_pixels_are_the_documents_and_lead_to_their_pixel(visit, pictures):
    page = opened(visit)
    expected = worst_pixels(pixel_error(pictures["good"].color, pictures["bad"].color))
    links = page.locator("[data-part=worst] li > a:first-child")
    assert links.all_inner_texts() == [f"{p['row']}, {p['col']}" for p in expected]
    assert [(p["row"], p["col"]) for p in expected] == [(ROW, COL), FAR]
    links.nth(1).click()
    assert (state(page)["row"], state(page)["col"]) == (str(expected[1]["row"]), str(expected[1]["col"]))
    assert page.inner_text("[data-part=where]") == f"Row {expected[1]['row']}, column {expected[1]['col']}"


def test_a_link_of_the_table_opens_the_viewer_and_the_rays(visit):
    page = visit(SCENE)
    page.click("#about-faulty a[href*='row=12']")
    page.wait_for_selector("#viewer[data-ready='good bad']")
    assert page.inner_text("[data-part=where]") == "Row 12, column 12"
    page.click("#about-faulty a[href='#rays-faulty-12-12']")
    assert page.locator("#rays-faulty-12-12 table").first.is_visible()
    assert page.complaints == []


def test_a_link_restores_the_view(visit):
    page = opened(visit, "#viewer&a=good&b=bad&view=error&kind=relative&exposure=1.5&row=13&col=16&zoom=4")
    page.keyboard.press("Escape")
    there = state(page)
    again = visit(SCENE + "#" + page.url.partition("#")[2])
    again.wait_for_selector("#viewer[data-ready='good bad']")
    assert state(again) == there and there["view"] == "error" and there["kind"] == "relative"
    assert again.input_value("[data-part=kind]") == "relative" and again.input_value("[data-part=exposure]") == "1.5"


@pytest.mark.parametrize("fragment", ["#viewer&a=nobody&b=%3Cb%3E&row=99999&col=-1&zoom=x&view=y", "#viewer&row=1e9&col=NaN",
                                      "#%E0%A4%A", "#viewer&most=Infinity&exposure=1e99"])
def test_a_bad_link_costs_nothing(visit, fragment):
    page = visit(SCENE + fragment)
    page.wait_for_timeout(300)
    assert page.complaints == [] and page.inner_text("h1").startswith("Sphere")


def test_the_keyboard_alone_reaches_everything(visit):
    page = visit(SCENE)
    for _ in range(80):
        page.keyboard.press("Tab")
        if page.evaluate("() => document.activeElement.dataset.part") == "open":
            break
    page.keyboard.press("Enter")
    page.wait_for_selector("#viewer[data-ready='good bad']")
    for _ in range(30):
        if page.evaluate("() => document.activeElement.dataset.part") == "canvas":
            break
        page.keyboard.press("Shift+Tab")
    for key in ("n", "2", "+", "+", "ArrowRight", "Shift+ArrowDown"):
        page.keyboard.press(key)
    found = state(page)
    row, col = map(int, re.findall(r"\d+", page.inner_text("[data-part=where]")))
    assert found["view"] == "b" and float(found["zoom"]) > 2 and (found["row"], found["col"]) == (str(row), str(col))
    assert page.inner_text("[data-part=say]").startswith(f"Row {row}, column {col}:")
    page.keyboard.press("0")
    page.keyboard.press("Escape")
    assert float(state(page)["zoom"]) == 1 and "row" not in state(page)


def test_touch_alone_reads_flips_and_zooms(visit, pictures):
    page = visit(SCENE, width=360, has_touch=True, is_mobile=True)
    page.tap("[data-part=open]")
    page.wait_for_selector("#viewer[data-ready='good bad']")
    page.locator("[data-part=canvas]").scroll_into_view_if_needed()
    box = page.locator("[data-part=canvas]").bounding_box()
    page.touchscreen.tap(box["x"] + box["width"] * (COL + 0.5) / WIDTH, box["y"] + box["height"] * (ROW + 0.5) / HEIGHT)
    assert page.inner_text("[data-part=where]") == f"Row {ROW}, column {COL}"
    assert float(cells(page, "green")[1]) == pictures["bad"].color[ROW, COL][1] and cells(page, "blue")[1] == "not a number"
    page.tap("[data-view=b]")
    page.tap("[data-zoom='2']")
    assert state(page)["view"] == "b" and float(state(page)["zoom"]) == 2
    assert page.evaluate(WIDER) == 0 and page.complaints == []


def test_downloads_hold_the_numbers(visit, pictures, tmp_path):
    import OpenImageIO as oiio

    page = opened(visit)
    saved = {}
    for kind in ("npz", "exr"):
        with page.expect_download() as waiting:
            page.click(f"[data-save=b-{kind}]")
        saved[kind] = tmp_path / waiting.value.suggested_filename
        waiting.value.save_as(saved[kind])
    with np.load(saved["npz"], allow_pickle=False) as file:
        for name in ("color", "t", "index", "status"):
            assert np.array_equal(file[name], getattr(pictures["bad"], name), equal_nan=name in ("color", "t"))
    image = oiio.ImageBuf(str(saved["exr"]))
    names, pixels = list(image.spec().channelnames), image.get_pixels(oiio.FLOAT)
    rgb = pixels[..., [names.index(c) for c in "RGB"]]
    assert np.array_equal(rgb, pictures["bad"].color.astype(np.float32), equal_nan=True)


def test_the_first_page_filters(visit):
    page = visit("index.html")
    page.select_option("[data-part=verdict]", "differs")
    assert page.inner_text("[data-part=matches]") == "1 comparison on 1 scene"
    page.select_option("[data-part=verdict]", "")
    page.fill("[data-part=text]", "no such scene")
    assert page.inner_text("[data-part=matches]") == "0 comparisons on 0 scenes"


def test_one_file_shows_a_scene_by_itself(browser, site, tmp_path, pictures):
    from raytruth.reports.single import single_file

    results = make_results(pictures["good"].scene)
    file = single_file(site, results, ["figure-05-sphere"], tmp_path / "sphere.html")
    page = browser.new_page()
    asked = []
    page.on("request", lambda r: asked.append(r.url))
    page.on("pageerror", lambda error: asked.append(str(error)))
    page.goto(f"file://{file}#viewer&a=good&b=bad&row={FAR[0]}&col={FAR[1]}")
    page.wait_for_selector("#viewer[data-ready='good bad']")
    assert [float(text) for text in cells(page, "red")[:2]] == [p.color[FAR][0] for p in (pictures["good"], pictures["bad"])]
    assert page.evaluate(SHOW_ALL) == [] and page.locator("a[href]:not([href^='#'])").count() == 0
    assert [url for url in asked if not url.startswith(("data:", f"file://{file}"))] == []
    page.close()


def test_one_file_shows_several_scenes_each_with_its_own_viewer(browser, tmp_path, pictures):
    from raytruth.reports.single import single_file

    swapped = {"good": pictures["bad"], "bad": pictures["good"]}  # of the second scene
    folder = make_folder(tmp_path / "results", {**pictures, **{f"twin-{name}": picture for name, picture in swapped.items()}})
    results = make_results(pictures["good"].scene)
    runs = {run.key: run for run in results.runs}
    twin = [runs[name].model_copy(update={"key": f"twin-{name}", "planes": f"runs/twin-{name}.npz", "scene": "twin"})
            for name in swapped]
    second = next(c for c in results.comparisons if c.id == "faulty").model_copy(
        update={"id": "twin-faulty", "scene": "twin", "reference": "twin-good", "test": "twin-bad"})
    results = results.model_copy(update={
        "scenes": [results.scenes[0], results.scenes[0].model_copy(update={"name": "twin", "title": "Twin"})],
        "runs": [*results.runs, *twin], "comparisons": [*results.comparisons, second]})
    documents.write(results, folder)
    html = reports.build(folder, tmp_path / "html").parent
    file = single_file(html, results, ["figure-05-sphere", "twin"], tmp_path / "sent" / "two.html")
    shutil.rmtree(html)
    page = browser.new_page()
    asked = []
    page.on("request", lambda r: asked.append(r.url))
    page.on("console", lambda m: asked.append(m.text))
    page.on("pageerror", lambda error: asked.append(str(error)))
    page.goto(f"file://{file}")
    assert page.evaluate(SHOW_ALL) == [] and page.evaluate(WIDER) == 0
    ids = page.evaluate("() => [...document.querySelectorAll('[id]')].map((found) => found.id)")
    assert len(ids) == len(set(ids))
    links = page.evaluate("() => [...document.querySelectorAll('a[href]')].map((link) => link.getAttribute('href'))")
    assert links and all(link.startswith("#") and link[1:].split("&")[0] in ids for link in links)
    assert "#twin-content" in links and "#figure-05-sphere-content" in links
    for word, order in (("figure-05-sphere", ("good", "bad")), ("twin", ("bad", "good"))):
        page.click(f"#{word}-viewer [data-part=open]")
        page.wait_for_selector(f"#{word}-viewer[data-ready='good bad']")
        page.goto(f"file://{file}#{word}-viewer&a=good&b=bad&row={FAR[0]}&col={FAR[1]}")
        page.wait_for_function(f"() => document.querySelector('#{word}-viewer [data-row=red] td').textContent")  # after the address
        reds = page.locator(f"#{word}-viewer [data-row=red] td").all_inner_texts()[:2]
        assert [float(text) for text in reds] == [pictures[name].color[FAR][0] for name in order]
    page.evaluate(f"""() => {{ // an address that has been followed by what a viewer remembers, before the page hears of it
        history.replaceState(null, "", "#twin-viewer&a=bad&b=good");
        const newURL = new URL("#twin-viewer&a=good&b=bad&row={ROW}&col={COL}", location).href;
        dispatchEvent(new HashChangeEvent("hashchange", {{ newURL }}));
    }}""")
    assert [float(text) for text in page.locator("#twin-viewer [data-row=red] td").all_inner_texts()[:2]] == [
        pictures[name].color[ROW, COL][0] for name in ("bad", "good")]
    assert [url for url in asked if not url.startswith(("data:", f"file://{file}"))] == []
    page.close()


def test_ten_thousand_comparisons_are_filtered(browser, tmp_path):
    """`pytest -s` prints the processor time it takes; the machine decides on that, not this test."""
    from raytruth.reports.build import environment, rendered, static
    from raytruth.reports.figures.pictures import Maps, ScenePictures
    from raytruth.reports.pages import arrange, front

    one = make_results(library.scene("figure-05-sphere"))
    scene, verdicts = one.scenes[0], ("agrees", "agrees", "agrees", "expected", "differs")
    scenes = [scene.model_copy(update={"name": f"scene-{k}", "title": f"Scene {k}"}) for k in range(2000)]
    comparisons = [one.comparisons[0].model_copy(update={"id": f"{s.name}--{k}", "scene": s.name, "verdict": verdict, "worst": []})
                   for s in scenes for k, verdict in enumerate(verdicts)]
    report = arrange(one.model_copy(update={"scenes": scenes, "comparisons": comparisons}))
    report.pictures.update({s.name: ScenePictures({}, {c.id: Maps(None, "none") for c in comparisons[5 * k:5 * k + 5]}, {}, {})
                            for k, s in enumerate(scenes)})
    templates = environment()
    for name, text in static(templates).items():
        (tmp_path / name).write_text(text, encoding="utf-8")
    pages = [replace(page, section="Findings") for page in front.pages(report)]
    (tmp_path / "index.html").write_text(rendered(templates, pages[0], report, pages), encoding="utf-8")
    assert (tmp_path / "index.html").stat().st_size <= 5e6
    page = browser.new_page()
    session = page.context.new_cdp_session(page)
    session.send("Performance.enable", {"timeDomain": "threadTicks"})  # of this page's thread: others may keep the machine busy
    spent = lambda: next(m["value"] for m in session.send("Performance.getMetrics")["metrics"] if m["name"] == "TaskDuration")
    page.goto(f"file://{tmp_path}/index.html")
    for text, told in (("scene 19", "555 comparisons on 111 scenes"), ("", "10000 comparisons on 2000 scenes, the first 120 shown")):
        page.evaluate("() => document.body.offsetHeight")
        before = spent()
        page.fill("[data-part=text]", text)
        page.evaluate("() => document.body.offsetHeight")
        seconds = spent() - before
        print(f"filtered 10 000 comparisons in {seconds:.3f} s of processor time")
        assert page.inner_text("[data-part=matches]") == told
    page.close()


def test_pictures_of_each_kind_of_page_are_taken_and_what_is_wrong_is_told(site, tmp_path, browser):
    from tools.screenshots import SCHEMES, WINDOWS, main, photographed

    few = tmp_path / "few"
    for name in ("index.html", "trust.html", SCENE, *(path.name for path in site.glob("*.css")), *(p.name for p in site.glob("*.js"))):
        (few / name).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(site / name, few / name)
    (few / "trust.html").write_text("<p style='width: 3000px'>wide</p><script>console.error('broken')</script>")
    wrong = photographed(few, tmp_path / "shots", browser)
    assert len(list((tmp_path / "shots").glob("*.png"))) == 3 * len(WINDOWS) * len(SCHEMES)
    told = [what for what in wrong if what.startswith("trust.html")]
    assert any("says 'broken'" in what for what in told) and any("wider than its window" in what for what in told)
    assert main([str(tmp_path), "-o", str(tmp_path / "none")]) == 2
