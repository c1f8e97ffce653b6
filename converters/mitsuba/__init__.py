"""Any scene as a Mitsuba 3 scene, made in memory (variant llvm_ad_rgb).

Geometry and camera are converted. The document's materials and lights have no stock counterpart in Mitsuba (lights
without fall-off, refraction without Fresnel's factors), so shapes carry Mitsuba's default material; the comparison
evaluates the document's own shading on Mitsuba's intersections.
"""

from .scene import MitsubaScene, Part, convert
from .sensor import document_directions, pixel_directions, sensor

__all__ = ["MitsubaScene", "Part", "convert", "document_directions", "pixel_directions", "sensor"]
