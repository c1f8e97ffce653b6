"""Certifying a picture: proofs for every ray, exact decisions for a sample, whole paths with 77 digits.

census.py   every ray of the picture decided once more by proof (first_hit.Proof), the same ray for both methods
audit.py    a stratified sample of rays decided by python-flint (line.py: what a ray's answer is, exactly)
paths.py    whole pixel paths recomputed by an independent tracer (precise.py)
run.py      the three together: `certify`, which returns a `Certificate`
"""

from .certificate import Certificate
from .run import certify

__all__ = ["Certificate", "certify"]
