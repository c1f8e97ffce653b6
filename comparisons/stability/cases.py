"""All families of the suite. To add one: write it like its neighbours and list it in its file's FAMILIES."""

from __future__ import annotations

from ..suites import choose
from .families import model, quadrics, root_set, roots
from .family import Family

FAMILIES: tuple[Family, ...] = (*quadrics.FAMILIES, *roots.FAMILIES, *root_set.FAMILIES, *quadrics.SECONDARY,
                                *model.FAMILIES)


def find(names: list[str]) -> tuple[Family, ...]:
    """The families called `names`; all of them for an empty list. Raises InputError for an unknown one."""
    return choose(names, {family.about.id: family for family in FAMILIES}, "--family: no family is called")
