"""Mitsuba's own light transport against the document's, one effect at a time.

Each case is set up so that theory says both pictures must be equal, with plugins that Mitsuba brings along wherever it
has them. Where physics and the document differ, a case measures the difference and holds it against what physics
predicts: a finding.
"""
