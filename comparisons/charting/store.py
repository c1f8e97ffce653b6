"""Finished measurements, kept under a hash of all that can change them."""

from __future__ import annotations

import hashlib
import json
import os
from pathlib import Path
from typing import TypeVar

from reference_tracer.scene.model import Scene

from ..document import Record
from ..machine import machine, packages, source_hash
from .results import FOLDER

Kept = TypeVar("Kept", bound=Record)


class Store:
    """The folder `chart/` of a results folder."""

    def __init__(self, folder: Path, turns: int):
        self.folder, self.turns = folder / FOLDER, turns
        self.folder.mkdir(parents=True, exist_ok=True)
        here = machine()
        self._always = [turns, here.processor, here.cores, packages(), source_hash()]

    def key(self, scene: Scene, *content) -> str:
        text = json.dumps([scene.hash, *content, self._always], sort_keys=True)
        return hashlib.sha256(text.encode()).hexdigest()[:24]

    def path(self, key: str, suffix: str) -> Path:
        return self.folder / f"{key}{suffix}"

    def find(self, key: str, kind: type[Kept]) -> Kept | None:
        try:
            return kind.model_validate_json(self.path(key, ".json").read_text(encoding="utf-8"))
        except (OSError, ValueError):
            return None

    def keep(self, key: str, record: Record) -> None:
        path = self.path(key, ".json")
        part = path.with_suffix(".part")
        part.write_text(record.model_dump_json(), encoding="utf-8")
        os.replace(part, path)
