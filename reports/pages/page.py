"""One page before it is written."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import PurePosixPath


@dataclass(frozen=True)
class Page:
    path: str  # of the file, relative to the report
    template: str
    content: dict = field(default_factory=dict)  # what the template sees besides `report`, `root` and `path`

    @property
    def root(self) -> str:
        """The way from this page back to the report's folder."""
        return "../" * (len(PurePosixPath(self.path).parts) - 1)
