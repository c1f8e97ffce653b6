"""Any scene as text in POV-Ray 3.7's scene description language, or a refusal that says what POV-Ray cannot express.

Only text is made here. POV-Ray is licensed under the AGPL: it runs as a process of its own, see comparisons.
"""

from .scene import Conversion, convert, object_of, scene_text

__all__ = ["Conversion", "convert", "object_of", "scene_text"]
