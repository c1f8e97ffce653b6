"""Which code a result was made by: the sources that its maker can reach by import, and what they import from elsewhere.

Hashing no more than that lets a result outlive every change of what it does not use.
"""

from __future__ import annotations

import ast
import hashlib
import re
import shutil
import subprocess
import sys
from collections.abc import Iterator
from functools import cache
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

from raytruth.reference_tracer import llvm

ROOT = Path(__file__).resolve().parents[2]  # where the packages of raytruth stand
OURS = ("raytruth.reference_tracer", "raytruth.converters", "raytruth.comparisons")
DISTRIBUTION = {"skimage": "scikit-image", "flint": "python-flint"}  # where it is not called as it is imported
COMPILED = {"drjit", "mitsuba"}  # what compiles its kernels by LLVM


@cache
def code(*modules: str) -> str:
    """A hash of all code behind `modules`: sources, versions of packages and of Python, the LLVM that is loaded.

    A module that is imported by a name made at run time is not followed: name it among `modules`.
    """
    digest = hashlib.sha256(f"python {sys.version_info[:2]}".encode())
    sources, packages = closure(*modules)
    for source in sorted(sources):
        digest.update(f"{source}\n".encode() + _file(source).read_bytes())
    for package in sorted(packages):
        digest.update(f"{package} {installed(package)}\n".encode())
    if packages & COMPILED:
        digest.update(_llvm().encode())
    return digest.hexdigest()[:24]


@cache
def closure(*modules: str) -> tuple[frozenset[str], frozenset[str]]:
    """Our modules that `modules` reach by import, themselves included, and the packages of others."""
    ours, others, waiting = set(), set(), list(modules)
    while waiting:
        name = waiting.pop()
        if name in ours:
            continue
        if not _is_ours(name):
            others.add(name.partition(".")[0])
        elif _file(name):
            ours.add(name)
            waiting += _imports(name)
    return frozenset(ours), frozenset(others - set(sys.stdlib_module_names))


@cache
def _imports(name: str) -> tuple[str, ...]:
    """The modules that the module `name` imports, anywhere in it, by a name that stands in the text."""
    file = _file(name)
    package = name if file.name == "__init__.py" else name.rpartition(".")[0]
    return tuple(found for node in ast.walk(ast.parse(file.read_bytes())) for found in _named(node, package))


def _named(node: ast.AST, package: str) -> Iterator[str]:
    match node:
        case ast.Import(names=names):
            yield from (alias.name for alias in names)
        case ast.ImportFrom(module=module, names=names, level=level):
            base = ".".join(filter(None, [*package.split(".")[:len(package.split(".")) + 1 - level], module])) \
                if level else module
            whole = [name for alias in names if _file(name := f"{base}.{alias.name}")]
            yield from whole
            if len(whole) < len(names):
                yield base
        case ast.Call(func=ast.Name(id="import_module") | ast.Attribute(attr="import_module"),
                      args=[ast.Constant(value=str(name)), *_]):
            yield name


def _is_ours(name: str) -> bool:
    return ".".join(name.split(".")[:2]) in OURS


@cache
def _file(name: str) -> Path | None:
    """The source of one of our modules; None if there is none."""
    if not _is_ours(name):
        return None
    path = ROOT.joinpath(*name.split(".")[1:])
    return next((p for p in (path.with_suffix(".py"), path / "__init__.py") if p.is_file()), None)


@cache
def installed(package: str) -> str:
    """The version of a package, by its name on import or on the index."""
    try:
        return version(DISTRIBUTION.get(package, package))
    except PackageNotFoundError:
        return "not installed"


@cache
def _llvm() -> str:
    """Which LLVM Dr.Jit loads: the file it is pointed at, and its size, since versions of one name are not one build."""
    path = llvm.choose()
    try:
        return f"{Path(path).resolve().name} {Path(path).stat().st_size}" if path else "none"
    except OSError:
        return str(path)


@cache
def program(name: str) -> str:
    """The version that an installed program tells of itself; "not installed" where there is none."""
    path = shutil.which(name)
    if path is None:
        return "not installed"
    try:
        told = subprocess.run([path, "--version"], capture_output=True, text=True, errors="replace", timeout=20)
    except (OSError, subprocess.TimeoutExpired):
        return "unknown"
    lines = [line.strip() for line in (told.stdout + "\n" + told.stderr).splitlines()]
    numbered = [line for line in lines if re.search(rf"{name}\W.*\d\.\d", line.replace("-", ""), re.IGNORECASE)
                and "/" not in line]
    return numbered[0] if numbered else "unknown"
