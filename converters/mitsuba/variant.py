"""Mitsuba in the variant that everything here is written for: fp32 on LLVM; its wheel has no double one.

Both Mitsuba and Dr.Jit are imported from here, because whoever imports Dr.Jit first settles which LLVM it loads.
"""

from raytruth.reference_tracer import llvm  # points Dr.Jit at a good LLVM; must come first

import drjit as dr  # isort: skip
import mitsuba as mi  # isort: skip

llvm.require()
mi.set_variant("llvm_ad_rgb")

__all__ = ["dr", "mi"]
