"""Shared by all tests: Dr.Jit must find its LLVM before any test module imports it."""

import pytest

import reference_tracer  # noqa: F401  chooses the LLVM library


@pytest.fixture
def as_written(monkeypatch):
    """Formulas are traced as they are written, not by their odd parts: for methods that have to bear any f."""
    from reference_tracer.surfaces import expression

    monkeypatch.setattr(expression, "odd_part", lambda tree: tree)
    expression.forms_of.cache_clear()
    yield
    expression.forms_of.cache_clear()
