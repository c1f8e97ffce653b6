"""What runs renderers against each other and measures how far their pictures agree."""

from raytruth import reference_tracer  # noqa: F401  points Dr.Jit at its LLVM before any module here imports drjit
