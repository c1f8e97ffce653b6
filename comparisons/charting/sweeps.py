"""What is charted: one row a sweep. A new renderer or a new parameter is a row of this table."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal

from .. import renderers
from ..renderers import RENDERERS

OURS = "reference"  # the process that runs our own first-hit methods


@dataclass(frozen=True)
class Contestant:
    """One point of a sweep: what a measuring process needs to know of it."""

    renderer: str  # OURS, or a name in RENDERERS
    settings: dict
    timed: dict = field(default_factory=dict)  # settings of timed runs only: what need not be made again

    @property
    def process(self) -> str:
        """Contestants of the same process name share a child process."""
        return OURS if self.renderer == OURS else renderers.find(self.renderer).module


@dataclass(frozen=True)
class Sweep:
    """A method over the `values` of its setting `key`; without a key it is a single point."""

    id: str
    method: str
    title: str
    kind: Literal["first hits", "converter", "control"]
    renderer: str
    settings: dict = field(default_factory=dict)
    key: str = ""
    parameter: str = ""
    values: tuple[float, ...] = ()
    brief: tuple[float, ...] = ()  # those of a short run
    timed: dict = field(default_factory=dict)

    @property
    def is_registered(self) -> bool:
        return self.renderer == OURS or self.renderer in RENDERERS

    def contestants(self, full: bool) -> list[tuple[float | None, Contestant]]:
        """Every value of the parameter with what is measured there."""
        if not self.key:
            return [(None, Contestant(self.renderer, self.settings, self.timed))]
        return [(value, Contestant(self.renderer, {**self.settings, self.key: value}, self.timed))
                for value in (self.values if full else self.brief)]

    def label(self, value: float | None) -> str:
        return "" if value is None else f"{self.parameter} {value:g}"


def _ours(id: str, title: str, method: str, precision: int = 64, group: str = "", **more) -> Sweep:
    settings = {"method": method, "precision": precision, **more.pop("settings", {})}
    return Sweep(id, group or method, title, "first hits", OURS, settings, **more)


STEPS = (0.5, 0.2, 0.1, 0.05, 0.02, 0.01, 0.005, 0.002, 0.001)
BRIEF_STEPS = (0.2, 0.1, 0.05, 0.02, 0.01, 0.005)
TOLERANCES = (1e-1, 1e-2, 1e-4, 1e-8, 1e-14)
RESOLUTIONS = (32, 64, 128, 256, 512)
BRIEF_RESOLUTIONS = (32, 64, 128)
ACCURACIES = (1e-2, 1e-3, 1e-4, 1e-6, 1e-8)

SWEEPS = (
    _ours("paper", "paper", "paper", key="step_size", parameter="step size", values=STEPS, brief=BRIEF_STEPS),
    _ours("paper-32", "paper, single precision", "paper", 32, key="step_size", parameter="step size", values=STEPS,
          brief=(0.1, 0.01)),
    _ours("paper-newton", "paper, step size 0.01", "paper", group="paper, Newton", settings={"step_size": 0.01},
          key="tolerance", parameter="Newton’s tolerance", values=TOLERANCES, brief=(1e-1, 1e-4)),
    _ours("descartes", "descartes", "descartes"),
    _ours("descartes-32", "descartes, single precision", "descartes", 32),
    _ours("interval", "interval", "interval"),
    _ours("interval-32", "interval, single precision", "interval", 32),
    _ours("exact", "exact", "exact"),
    _ours("exact-32", "exact, single precision", "exact", 32),
    _ours("proof", "proof", "proof"),
    Sweep("mitsuba-mesh", "Mitsuba, mesh", "Mitsuba, mesh", "converter", "mitsuba-mesh", {"repeat": False},
          "resolution", "resolution", RESOLUTIONS, BRIEF_RESOLUTIONS),
    Sweep("mitsuba-native", "Mitsuba, mesh", "Mitsuba, native shapes", "converter", "mitsuba-native",
          {"shapes": "native", "repeat": False}),
    Sweep("mitsuba-sdfgrid", "Mitsuba, grid", "Mitsuba, grid of distances", "converter", "mitsuba-sdfgrid",
          {"repeat": False}, "resolution", "resolution", RESOLUTIONS[:4], (32, 64)),
    Sweep("embree", "Embree", "Embree, mesh", "converter", "embree", {}, "resolution", "resolution", RESOLUTIONS,
          (32, 128)),
    Sweep("povray-isosurface", "POV-Ray", "POV-Ray, isosurface", "converter", "povray", {"shapes": "isosurface"},
          "accuracy", "accuracy", ACCURACIES, (1e-3, 1e-6), {"planes": False}),
    Sweep("povray-native", "POV-Ray", "POV-Ray, native shapes", "converter", "povray", {"shapes": "native"},
          timed={"planes": False}),
    Sweep("crude", "crude control", "crude control: one sample a ray", "control", OURS,
          {"method": "crude", "precision": 64}),
    Sweep("oracle", "oracle control", "oracle control: hands the truth through", "control", OURS, {"method": "oracle"}),
)
