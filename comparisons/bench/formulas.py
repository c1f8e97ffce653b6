"""Many formulas, one after another in one process, as by someone who tries them: each another tree, each a small picture.

`python -m raytruth.comparisons.bench.formulas COUNT` renders them; the benchmark times it with an empty kernel cache.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from random import Random

from raytruth.reference_tracer import llvm
from raytruth.reference_tracer.scene.model import Camera, Light, Object, Scene
from raytruth.reference_tracer.surfaces import Expression
from raytruth.reference_tracer.tracer.render import render

SIZE = 80, 60
TERMS = (  # what is added to a ball; half of them are polynomials, as are half of the formulas that people write
    "{a}^{m}*{b}", "{a}*{b}*{c}", "({a}^2 - {b}^2)^{n}", "({a} + {b})^{m}", "{a}^2*{b}^2", "({a}^2 + {b}*{c} - {k})^2",
    "sin({m}*{a})*cos({n}*{b})", "exp({a} - {b}^{n})", "sqrt({a}^2 + {b}^2 + {k})", "abs({a} + {k}*{b})",
    "max({a}, {b}*{c}, {k})", "{a}/({b}^2 + {k})")


def formulas() -> Iterator[Expression]:
    """Formulas without end, always the same, no two of which have one tree: more than their numbers is different."""
    random, seen = Random("formulas"), set()
    while True:
        ball = " + ".join(f"{axis}^{random.choice((2, 2, 4))}" for axis in "xyz")
        terms = random.sample(TERMS[:6] if len(seen) % 2 else TERMS, random.choice((1, 2, 2, 3)))
        text = f"{ball} - 1"
        for term in terms:
            a, b, c = random.sample("xyz", 3)
            m, n = random.choice((2, 3, 4, 5)), random.choice((1, 2, 3))
            text += f" {random.choice('+-')} {random.uniform(0.1, 0.4):.2f}*" + term.format(
                a=a, b=b, c=c, m=m, n=n, k=f"{random.uniform(0.1, 0.9):.2f}")
        formula = Expression(formula=text)
        if formula.family not in seen:
            seen.add(formula.family)
            yield formula


def scene(formula: Expression) -> Scene:
    width, height = SIZE
    return Scene(camera=Camera(width=width, height=height, position=(1.8, 1.4, -2.8), direction=(-1.8, -1.4, 2.8), fov=50.0),
                 objects=(Object(surface=formula),), lights=(Light(position=(0.0, 9.0, -9.0)),))


def main() -> None:
    llvm.narrow_kernels()  # each kernel sees few rays, as in a command that renders small pictures
    for _, formula in zip(range(int(sys.argv[1])), formulas()):
        render(scene(formula))


if __name__ == "__main__":
    main()
