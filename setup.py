"""What pyproject.toml cannot say: packages that stand at the repository's top are installed as parts of `raytruth`."""

from setuptools import find_packages, setup

TOP = ("reference_tracer", "converters", "comparisons", "reports")
INSIDE = find_packages(include=[f"{name}{rest}" for name in TOP for rest in ("", ".*")])

setup(packages=find_packages(include=["raytruth", "raytruth.*"]) + [f"raytruth.{name}" for name in INSIDE],
      package_dir={f"raytruth.{name}": name for name in TOP})
