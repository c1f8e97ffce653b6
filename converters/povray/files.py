"""A scene as a file for POV-Ray: the text that is also rendered here, and in its first lines how to render it alike.

Two things that our own runs add afterwards are no part of a file: POV-Ray's pictures end at 1, and rays beyond the last
generation are black where the document has the background (decision D1).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from .scene import Conversion


def different(converted: Conversion) -> list[str]:
    """What of the model a picture of the file does not show as it is, in sentences."""
    scene, told = converted.scene, []
    if converted.brightest != 1:
        told.append(f"colours are the model's divided by {converted.brightest!r}, the brightest that it may have")
    if converted.needs_share:
        told.append(f"rays beyond generation {scene.tracing.max_depth} end black, and in the background in the model")
    if scene.tracing.samples > 1:
        told.append(f"the model's pixel is the mean of {scene.tracing.samples} x {scene.tracing.samples} of a picture that "
                    "many times as wide and high")
    if guessed := [k for k in converted.gradients if k not in converted.proven]:
        told.append(f"max_gradient of object {', '.join(map(str, guessed))} is measured, not proven: heed POV-Ray's warnings")
    if converted.remark:
        told.append(converted.remark)
    return told


def file_text(converted: Conversion, name: str, about: Sequence[str]) -> str:
    """The whole file, which will be called `name`; `about` are printable lines that it tells of itself."""
    camera, samples = converted.scene.camera, converted.scene.tracing.samples
    command = (f"povray +I{name} +W{samples * camera.width} +H{samples * camera.height} +FN16 File_Gamma=1.0 -A -D")
    comment = "".join(f"// {line}\n" for line in (*about, command))
    # misses show the background here; what our own runs add to black ones holds it already
    shown = replace(converted, needs_share=False)
    return comment + shown.text("color")
