"""The literal search of the oracle with all steps of a ray looked at in one go: the same answers, in less time."""

from raytruth.comparisons.verdicts.oracle import AllSteps

__all__ = ["AllSteps"]
