"""Shared by all tests: Dr.Jit must find its LLVM before any test module imports it."""

import reference_tracer  # noqa: F401  chooses the LLVM library
