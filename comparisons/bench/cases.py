"""What is timed: groups of bars, most of them one contestant against another on the document's scenes."""

from __future__ import annotations

import math
import os
import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import drjit as dr
import numpy as np

from raytruth.reference_tracer.backend import backend, use_threads
from raytruth.reference_tracer.errors import InputError, UnsupportedError
from raytruth.reference_tracer.first_hit import METHODS
from raytruth.reference_tracer.scene import library
from raytruth.reference_tracer.scene.model import Camera, Light, Material, Object, Scene
from raytruth.reference_tracer.surfaces.plane import Plane
from raytruth.reference_tracer.surfaces.sphere import Sphere
from raytruth.reference_tracer.tracer.camera_rays import camera_wave
from raytruth.reference_tracer.tracer.image_files import planes_of, save
from raytruth.reference_tracer.tracer.render import UNDECIDED, Picture, Renderer, render
from raytruth.reference_tracer.tracer.world import World

from ..execution.machine import peak_kib
from ..execution.pool import Pool, Task
from ..renderers import povray
from ..renderers import render as render_with
from ..suites import choose
from . import formulas, port
from .document import Clock, Row
from .timing import QUIET, Contestant, Cost, Measured, deciding, interleave, judged, row, spread, timed

PLANES = ("color", "index", "t")  # those that the port makes
THREADS = 2  # of the port and of the tracer, unless threads are what is measured
FEW_RAYS, MANY_RAYS = 640 * 480, 1440 * 1080  # camera rays of a picture at most

SINGLE = tuple(name for name in library.names() if library.scene(name).figure in {f"Figure {k}" for k in range(4, 10)})
RICH = tuple(name for name in library.names() if library.scene(name).figure in {f"Figure {k}" for k in range(10, 20)})


@dataclass(frozen=True)
class Options:
    """What a user may choose about a run of the benchmark."""

    turns: int = 5
    size: str | None = None  # "640x480", or "own" for the scenes'; None: what the group finds enough
    clock: Clock | None = None  # None: wall time on a quiet machine
    budget: float = 120.0  # seconds a row's turns may take
    quick: bool = False  # smaller pictures

    def sized(self, name: str, most_rays: int) -> Scene:
        """The shipped scene `name`, shrunk to at most `most_rays` camera rays (quick: a quarter of them)."""
        scene = library.scene(name)
        if self.size == "own":
            return scene
        if self.size:
            return scene.resized(*map(int, self.size.split("x")))
        width, height = scene.camera.width, scene.camera.height
        most = most_rays / 4 if self.quick else most_rays
        scale = min(1.0, math.sqrt(most / (width * height)) / scene.tracing.samples)
        return scene.resized(max(1, round(scale * width)), max(1, round(scale * height)))

    def interleaved(self, contestants: list[Contestant]) -> Measured:
        return interleave(contestants, self.turns, self.budget)


def picture_size(scene: Scene) -> str:
    """The size of the scene's picture in words."""
    n = scene.tracing.samples
    return f"{scene.camera.width} x {scene.camera.height}" + (f", {n} x {n} samples" if n > 1 else "")


# --- contestants, each on a scene -------------------------------------------------------------------------------------
def tracer(scene: Scene, method: str = "exact", name: str = "", threads: int = THREADS) -> Contestant:
    """Ours, with the planes that the port makes; what its first picture records and compiles is not compared."""
    renderer = Renderer(scene, method, threads=threads)

    def run() -> Cost:
        use_threads(threads)  # they belong to the process, not to the renderer
        return timed(lambda: renderer.picture(PLANES))

    return Contestant(name or method, run)


def paper(scene: Scene) -> Contestant:
    return tracer(scene, "paper")


def cpp_port(scene: Scene, step_size: float | None = None) -> Contestant:
    port.build()  # its compiler's time is not the port's
    scene = scene if step_size is None else scene.traced_with(step_size=step_size)
    return Contestant("C++ port", lambda: port.render(scene, THREADS).cost, compiles=False)


def pov_ray(scene: Scene, **settings) -> Contestant:
    """Its wall time holds half a second of starting; its processor time is that of tracing alone."""
    def run() -> Cost:
        facts = povray.render(scene, planes=False, threads=THREADS, **settings).metadata
        return Cost(facts["first"], facts["cpu"])

    return Contestant("POV-Ray", run, compiles=False)


# --- groups -----------------------------------------------------------------------------------------------------------
@dataclass(frozen=True)
class Group:
    """Bars of one kind: `measure` returns the rows of one of its `cases`."""

    name: str
    about: str
    cases: tuple[str, ...]
    measure: Callable[[str, Options], list[Row]]


def versus(name: str, about: str, cases: tuple[str, ...], what: str, slow: Callable[[Scene], Contestant],
           fast: Callable[[Scene], Contestant], bar: float | Callable[[str], float], *, rays: int = FEW_RAYS,
           clock: Clock | None = None, quiet: bool = False, step_size: float | None = None, note: str = "") -> Group:
    """A group that says how many times longer `slow` takes than `fast` for the picture of a scene.

    `clock` decides whatever the user chose; on a machine that is not `quiet`, where it must be, a case is refused.
    """
    def measure(case: str, options: Options) -> list[Row]:
        scene = options.sized(case, rays)
        scene = scene if step_size is None else scene.traced_with(step_size=step_size)
        contestants = [fast(scene), slow(scene)]
        measured = options.interleaved(contestants)
        if quiet and measured.others > QUIET:
            raise UnsupportedError(f"other programs kept {measured.others:.2f} cores busy, and only wall time can tell")
        return [row(f"{name}/{case}", what, measured, contestants[1].name, contestants[0].name,
                    bar(case) if callable(bar) else bar, clock or options.clock, picture=picture_size(scene),
                    note=note.format(scene.tracing.step_size))]

    return Group(name, about, cases, measure)


def first_hits(case: str, options: Options) -> list[Row]:
    base, truth = "paper", "proof"
    scene = options.sized(case, FEW_RAYS).traced_with(step_size=0.1, samples=1)
    use_threads(THREADS)
    worlds = {method: World(scene, method, backend()) for method in METHODS}
    world = worlds[base]
    wave = camera_wave(world, world.camera_sides(), 0, scene.camera.width * scene.camera.height, 1)
    hits = {}

    def find(method: str) -> None:
        hits[method] = worlds[method].nearest(wave.ray)
        dr.eval(hits[method])
        dr.sync_thread()

    def wrong(method: str) -> str:
        """How many rays met another object than is proven; those that either leaves undecided do not count."""
        hit, undecided = hits[method], hits[method].undecided.numpy()
        differ = (hit.index.numpy() != hits[truth].index.numpy()) & ~undecided & ~hits[truth].undecided.numpy()
        return f"{np.sum(differ)} wrong rays, {np.sum(undecided)} undecided"

    measured = options.interleaved([Contestant(m, lambda m=m: timed(lambda: find(m))) for m in METHODS])
    return [row(f"first-hits/{case}/{method}", f"{base} at step size {scene.tracing.step_size:g} / {method}", measured, base,
                method, None, options.clock, picture=picture_size(scene), note=wrong(method))
            for method in METHODS if method != base]


MOST_WRONG = 10  # pixels of a mesh's picture that show another object, or none
RESOLUTIONS = (16, 24, 32, 48, 64, 96, 128, 192, 256, 384, 512)


def mitsuba_mesh(case: str, options: Options) -> list[Row]:
    scene = options.sized(case, FEW_RAYS)
    resolution, wrong = least_resolution(scene)
    tracing = []  # seconds without building, of every run

    def mesh() -> Cost:
        pictures = []
        cost = timed(lambda: pictures.append(_mesh(scene, resolution)))
        tracing.append(pictures[0].metadata["first"])
        return cost

    measured = options.interleaved([tracer(scene), Contestant("Mitsuba", mesh)])
    about = {"picture": picture_size(scene), "note": f"resolution {resolution}: {wrong} wrong pixels"}
    whole = row(f"mitsuba-mesh/{case}/build-and-trace", "Mitsuba, mesh built and traced / exact", measured, "Mitsuba",
                "exact", 10.0, options.clock, **about)
    measured.costs["Mitsuba"] = [Cost(seconds, seconds) for seconds in tracing[1:]]  # the first one compiled
    alone = row(f"mitsuba-mesh/{case}/trace", "Mitsuba, tracing alone / exact", measured, "Mitsuba", "exact", 1.0, "wall",
                **about)
    return [whole, alone.model_copy(update={"cpu": None})]


def least_resolution(scene: Scene) -> tuple[int, int]:
    """The coarsest mesh with at most MOST_WRONG wrong pixels, and how many it has. Raises UnsupportedError."""
    truth = render(scene, "exact")
    for resolution in RESOLUTIONS:
        wrong = int(np.sum((_mesh(scene, resolution).index != truth.index) & (truth.status != UNDECIDED)))
        if wrong <= MOST_WRONG:
            return resolution, wrong
    raise UnsupportedError(f"{scene.name}: no mesh up to resolution {RESOLUTIONS[-1]} has at most {MOST_WRONG} wrong "
                           f"pixels; the last has {wrong}")


def _mesh(scene: Scene, resolution: int) -> Picture:
    return render_with("mitsuba-mesh", scene, {"resolution": resolution, "repeat": False})


def objects(case: str, options: Options) -> list[Row]:
    size = (320, 240) if options.quick else (640, 480)
    rows = []
    for method, bar in (("exact", 4.0), ("paper", None)):
        measured = options.interleaved([tracer(spheres(n, *size), method, f"{n} spheres") for n in (10, 100)])
        rows.append(row(f"objects/{method}", f"100 spheres / 10 spheres, {method}", measured, "100 spheres", "10 spheres",
                        bar, options.clock, sense="<=", picture=f"{size[0]} x {size[1]}", note="mirrors above a floor"))
    return rows


def spheres(count: int, width: int, height: int) -> Scene:
    """`count` mirroring balls in rows above a floor, whose area in the picture is about the same for any count."""
    columns = round(math.sqrt(count * 2))
    spacing = 6 / columns
    rows = math.ceil(count / columns)
    balls = [Object(surface=Sphere(center=((k % columns - (columns - 1) / 2) * spacing,
                                           (k // columns - (rows - 1) / 2) * spacing, 7 + 0.5 * math.sin(2.4 * k)),
                                   r=0.4 * spacing),
                    material=Material(color=(0.9, 0.5 + 0.4 * math.cos(k), 0.3), reflection=0.3))
             for k in range(count)]
    floor = Object(surface=Plane(center=(0.0, -2.5, 0.0), a=0.0, b=1.0, c=0.0))
    return Scene(name=f"spheres-{count}", camera=Camera(width=width, height=height), objects=(floor, *balls),
                 lights=(Light(position=(3.0, 5.0, 0.0)), Light(position=(-4.0, 4.0, 1.0), brightness=(0.4, 0.4, 0.4))))


SIZES = {(1920, 1080): 16, (3840, 2160): 4, (7680, 4320): 1}  # how many pictures make as many pixels as the largest


def resolution(case: str, options: Options) -> list[Row]:
    samples = 1 if options.quick else 4
    peaks = {}

    def pictures(size: tuple[int, int], count: int) -> Cost:
        arguments = {"scene": case, "size": size, "samples": samples, "count": count}
        with Pool(1) as pool:  # in a process of its own, so that its peak memory is its own
            found = pool.ask(Task(case, case, f"{__name__}:in_worker", arguments, 3600.0))
        if found["state"] != "ok":
            raise InputError(f"{case} at {size[0]} x {size[1]}: {found['message']}")
        peaks[size] = found["peak_gib"]
        return Cost(found["wall"], found["cpu"])

    measured = interleave([Contestant(f"{w} x {h}", lambda size=(w, h), n=n: pictures(size, n), compiles=False)
                           for (w, h), n in SIZES.items()], 1, options.budget)
    seconds = {c: [getattr(cost[0], c) for cost in measured.costs.values()] for c in ("wall", "cpu")}
    growth = {c: spread([max(costs) / min(costs)]) for c, costs in seconds.items()}
    clock = deciding(options.clock, measured.others)
    about = {"sense": "<=", "turns": 1, "picture": f"{samples} x {samples} samples"}
    return [judged(Row(key=f"resolution/{case}/memory", what="peak memory of a 7680 x 4320 picture and its file", unit="GiB",
                       bar=3.0, value=peaks[7680, 4320], **about)),
            judged(Row(key=f"resolution/{case}/time", what="slowest / fastest time a pixel, 1920 x 1080 to 7680 x 4320",
                       bar=1.15, clock=clock, **growth, value=growth[clock].median, others=round(measured.others, 3),
                       seconds=measured.seconds(), **about))]


def in_worker(arguments: dict) -> dict:
    """Renders one scene `count` times: {"wall", "cpu": seconds, "peak_gib"}.

    Kernels are compiled before the clock starts; the last picture is saved when it has stopped, so that the peak is that
    of making a file.
    """
    scene = library.find(arguments["scene"])
    sized = lambda *size: scene.resized(*size, samples=arguments["samples"])
    with tempfile.TemporaryDirectory(prefix="raytruth-") as folder:
        file = Path(folder) / "picture.png"
        picture = render(sized(160, 90), "exact", planes=planes_of(file))

        def make():
            nonlocal picture
            for _ in range(arguments["count"]):
                picture = None  # two pictures at a time would double the peak
                picture = render(sized(*arguments["size"]), "exact", planes=planes_of(file))

        cost = timed(make)
        save(picture, file)
    return {"state": "ok", "wall": cost.wall, "cpu": cost.cpu, "peak_gib": peak_kib() / 2**20}


def in_process(kernels: Path, *module: str) -> Cost:
    """One run of `python -m module...`, its kernels cached in the folder `kernels`."""
    kernels.mkdir(exist_ok=True)
    start, before = time.perf_counter(), resource.getrusage(resource.RUSAGE_CHILDREN)
    done = subprocess.run([sys.executable, "-P", "-m", *module], capture_output=True, text=True,
                          env={**os.environ, "DRJIT_CACHE_DIR": str(kernels)})
    wall, after = time.perf_counter() - start, resource.getrusage(resource.RUSAGE_CHILDREN)
    if done.returncode:
        reason = (done.stderr.strip().splitlines() or ["no reason given"])[-1]
        raise InputError(f"python -m {' '.join(module)} failed: {reason}")
    return Cost(wall, after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime)


DISTINCT = {"60-formulas": 5.0, "500-formulas": 40.0}  # seconds


def distinct_formulas(case: str, options: Options) -> list[Row]:
    count, _ = case.split("-")
    with tempfile.TemporaryDirectory(prefix="raytruth-") as folder:
        fresh = (Path(folder) / f"fresh-{k}" for k in range(options.turns))
        measured = options.interleaved([
            Contestant(case, lambda: in_process(next(fresh), formulas.__name__, count), compiles=False)])
    wall, cpu = (spread([getattr(c, clock) for c in measured.costs[case]]) for clock in ("wall", "cpu"))
    width, height = formulas.SIZE
    return [judged(Row(key=f"formulas/{case}", what=f"process start to end, {count} distinct formulas, empty kernel cache",
                       unit="s", bar=DISTINCT[case], sense="<=", clock="wall", wall=wall, cpu=cpu, value=wall.median,
                       turns=len(measured.costs[case]), others=round(measured.others, 3), picture=f"{width} x {height}"))]


def first_picture(case: str, options: Options) -> list[Row]:
    bars, size = {"empty kernel cache": 3.0, "warm kernel cache": 1.2}, "640x480"  # seconds

    def command(kernels: Path) -> Cost:
        return in_process(kernels, "raytruth", "render", case, "--size", size, "-o", str(kernels / "picture.png"))

    with tempfile.TemporaryDirectory(prefix="raytruth-") as folder:
        fresh = (Path(folder) / f"fresh-{k}" for k in range(options.turns))
        measured = options.interleaved([
            Contestant("empty kernel cache", lambda: command(next(fresh)), compiles=False),
            Contestant("warm kernel cache", lambda: command(Path(folder) / "kept"))])
    rows = []
    for name, bar in bars.items():
        wall, cpu = (spread([getattr(c, clock) for c in measured.costs[name]]) for clock in ("wall", "cpu"))
        rows.append(judged(Row(
            key=f"first-picture/{case}/{name.split()[0]}", what=f"process start to file, {name}", unit="s", bar=bar,
            sense="<=", clock="wall", wall=wall, cpu=cpu, value=wall.median, turns=len(measured.costs[name]),
            others=round(measured.others, 3), picture=size.replace("x", " x "))))
    return rows


_STARTING = "POV-Ray's process takes most of a second to start; the processor time of tracing alone is compared."
GROUPS = {group.name: group for group in (
    versus("paper-vs-port", "The document's own method against a plain C++ port of it, at the same step size.",
           SINGLE + RICH, "C++ port / paper, same step size", cpp_port, paper,
           lambda case: 10.0 if case in RICH else 15.0, note="step size {:g}"),
    versus("exact-vs-port", "Exact first hits, which miss nothing, against a C++ port whose steps are so small that it "
           "misses little.", library.names(), "C++ port at step size 0.01 / exact",
           lambda scene: cpp_port(scene, 0.01), tracer, 60.0),
    versus("exact-vs-paper", "Exact first hits against the document's method, both ours: missing nothing should cost "
           "nothing.", library.names(), "paper at step size 0.1 / exact", paper, tracer, 1.0, rays=2_000_000, step_size=0.1),
    versus("povray-isosurface", "POV-Ray's isosurface, the established tracer of f(x, y, z) = 0, against exact first hits "
           f"on single surfaces. {_STARTING}", SINGLE, "POV-Ray isosurface of accuracy 1e-06 / exact",
           lambda scene: pov_ray(scene, shapes="isosurface", accuracy=1e-6), tracer, 20.0, clock="cpu"),
    versus("povray-native", f"POV-Ray with its native primitives against exact first hits: full pictures. {_STARTING}",
           library.names(), "POV-Ray, native primitives / exact", lambda scene: pov_ray(scene, shapes="native"), tracer,
           4.0, rays=MANY_RAYS, clock="cpu"),
    Group("mitsuba-mesh", "Mitsuba on a mesh just fine enough to have hardly a wrong pixel, against exact first hits.",
          SINGLE, mitsuba_mesh),
    versus("threads", "Two threads against one. Only wall time can tell, so a machine that is not quiet cannot.",
           ("figure-02-16-samples", "figure-07-torus", "figure-17-scene1", "figure-18-scene2"),
           "1 thread / 2 threads, exact", lambda scene: tracer(scene, name="1 thread", threads=1),
           lambda scene: tracer(scene, name="2 threads", threads=2), 1.85, rays=MANY_RAYS, clock="wall", quiet=True),
    Group("resolution", "Growth with the picture: memory of 7680 x 4320 pixels at 4 x 4 samples, and time a pixel at a "
          "sixteenth of it up.", ("figure-02-16-samples",), resolution),
    Group("objects", "A hundred spheres against ten that cover as much of the picture.", ("spheres",), objects),
    Group("first-picture", "From starting the command to the first picture's file, as a user sees it, with and without "
          "compiling kernels.", ("figure-05-sphere",), first_picture),
    Group("formulas", "Many formulas in one process, each another tree and a small picture: they share a kernel, which is "
          "compiled once.", tuple(DISTINCT), distinct_formulas),
    Group("first-hits", "The first-hit methods among themselves: camera rays of single surfaces, nothing shaded. No bars, "
          "only information.", SINGLE, first_hits))}


def find(names: list[str]) -> tuple[Group, ...]:
    """The groups called `names`, all of them if none is given. Raises InputError."""
    return choose(names, GROUPS, "unknown group")
