"""Mitsuba in the variant that everything here is written for: fp32 on LLVM, the wheel has no double one."""

import reference_tracer  # noqa: F401  chooses the LLVM library before Mitsuba loads Dr.Jit

import mitsuba as mi  # isort: skip

mi.set_variant("llvm_ad_rgb")
