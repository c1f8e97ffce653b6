"""All families of the suite. To add one: write it like its neighbours and list it in its file's FAMILIES."""

from __future__ import annotations

from reference_tracer.errors import InputError

from .families import model, quadrics, root_set, roots
from .family import Family

FAMILIES: tuple[Family, ...] = (*quadrics.FAMILIES, *roots.FAMILIES, *root_set.FAMILIES, *quadrics.SECONDARY,
                                *model.FAMILIES)


def find(names: list[str]) -> list[Family]:
    """The families called `names`; all of them for an empty list. Raises InputError for an unknown one."""
    known = {family.about.id: family for family in FAMILIES}
    for name in names:
        if name not in known:
            raise InputError(f"--family: no family is called {name!r}; choose from {', '.join(known)}")
    return [known[name] for name in names] or list(FAMILIES)
