"""What the pages say of the scene format comes from the classes that read it: a table a class, in place of a marker."""

from __future__ import annotations

from pydantic import BaseModel

from raytruth.reference_tracer.scene import model

MARKER = "<!-- generated: keys -->"
PARTS = (model.Scene, model.Camera, model.Object, model.Material, model.Rotation, model.Light, model.Tracing)


def on_page_markdown(markdown: str, **_) -> str:
    """A hook of MkDocs."""
    return markdown.replace(MARKER, keys())


def keys() -> str:
    """The keys of every part of a scene, as Markdown tables."""
    return "\n\n".join(f"### {part.__name__}\n\n{(part.__doc__ or '').strip()}\n\n{_table(part)}" for part in PARTS)


def _table(part: type[BaseModel]) -> str:
    rows = ["| key | default | meaning |", "|---|---|---|"]
    for name, field in part.model_fields.items():
        default = "required" if field.is_required() else f"`{_written(field.get_default())}`"
        rows.append(f"| `{field.alias or name}` | {default} | {(field.description or '').replace('|', chr(92) + '|')} |")
    return "\n".join(rows)


def _written(value) -> str:
    return "…" if isinstance(value, BaseModel) else f"{value!r}".replace("|", "\\|")
