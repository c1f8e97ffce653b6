"""The documents a report is made of beside the results: each is optional, and its pages come with it."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from comparisons.agreement import records as agreement
from comparisons.attribution import document as attribution
from comparisons.charting import document as charting
from comparisons.document import Record
from comparisons.planning import document as planning
from comparisons.stability import document as stability
from comparisons.transport import document as transport

READERS: dict[str, Callable[[Path], Record]] = {
    agreement.FILE: agreement.read, stability.FILE: stability.read, transport.FILE: transport.read, planning.FILE: planning.read,
    attribution.FILE: attribution.read, charting.FILE: charting.read}


def read_all(folder: Path) -> dict[str, Record]:
    """The documents that `folder` holds, by the name of their file. Raises InputError for one that cannot be read."""
    return {name: read(folder) for name, read in READERS.items() if (folder / name).exists()}
