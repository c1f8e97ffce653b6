"""Names of files and anchors: made from untrusted texts, safe on every file system, the same on every rebuild."""

from __future__ import annotations

import hashlib
import re

LONGEST = 80


def slug(text: str) -> str:
    """`text` itself if it is a plain name already; else what is plain of it, and a hash that keeps it apart."""
    plain = re.sub(r"[^a-z0-9-]+", "-", text.lower()).strip("-")[:LONGEST].strip("-")
    if plain and plain == text:
        return plain
    return f"{plain}-{hashlib.sha256(text.encode('utf-8', 'surrogatepass')).hexdigest()[:8]}".lstrip("-")

