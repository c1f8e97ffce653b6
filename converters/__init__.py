"""From scenes of implicit surfaces to what other renderers take: meshes, and scenes of those renderers."""

from raytruth import reference_tracer  # noqa: F401  points Dr.Jit at its LLVM before any module here imports drjit
