"""The cases, one file an effect: a new one is a file with a tuple CASES, listed here."""

from __future__ import annotations

from importlib import import_module

from reference_tracer.errors import InputError

FILES = ("shading", "shadow", "reflection", "refraction", "total_reflection", "mixing", "multisampling")


def all_cases() -> tuple:
    """Every case, in the order in which the document speaks of effects."""
    return tuple(case for file in FILES for case in import_module(f"{__name__}.{file}").CASES)


def module_of(case) -> str:
    """The module that holds a case."""
    return next(name for file in FILES if case in import_module(name := f"{__name__}.{file}").CASES)


def find(ids) -> tuple:
    """The cases called `ids`; all, if there are none. Raises InputError."""
    known = {case.id: case for case in all_cases()}
    for id in ids:
        if id not in known:
            raise InputError(f"unknown case {id!r}; choose one of {', '.join(known)}")
    return tuple(known[id] for id in ids) if ids else tuple(known.values())
