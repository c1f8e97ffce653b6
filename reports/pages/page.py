"""One page before it is written."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import PurePosixPath

import numpy as np


@dataclass(frozen=True)
class Summary:
    """What the first page says of another one."""

    title: str
    text: str  # what is shown there
    finding: str  # in one sentence, printed bold; "" where there is none
    link: str  # the words that lead there


@dataclass(frozen=True)
class Page:
    path: str  # of the file, relative to the report
    template: str
    content: dict = field(default_factory=dict)  # what the template sees besides `report`, `root`, `path` and `bar`
    nav: str = ""  # its name in the bar at the top of every page; "" keeps it out
    summary: Summary | None = None  # only of a page in the bar
    pictures: dict[str, np.ndarray] = field(default_factory=dict)  # files beside it: path to (h, w, 3) uint8

    @property
    def root(self) -> str:
        """The way from this page back to the report's folder."""
        return "../" * (len(PurePosixPath(self.path).parts) - 1)
