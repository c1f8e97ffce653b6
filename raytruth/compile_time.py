"""What a command tells of the time that its kernels will take to compile."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

UNTOLD = 10.0  # seconds that compiling may take at most without being told


@contextmanager
def compile_time_announced(scene, bar) -> Iterator[None]:
    """Says, before they are compiled, how long kernels of `scene` will take that may take long."""
    from raytruth.reference_tracer.tracer.compilation import heard
    from raytruth.reference_tracer.tracer.estimate import duration

    def tell(work) -> None:
        low, high = work.seconds
        if high > UNTOLD:
            kernels = "a kernel" if work.kernels == 1 else f"{work.kernels} kernels"
            bar.log(f"raytruth: {scene.name}: {kernels} of {work.operations:,} operations will take {duration(low)} to "
                    f"{duration(high)} to compile, unless compiled before")

    with heard(tell):
        yield
