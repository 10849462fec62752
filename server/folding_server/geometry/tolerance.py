"""The one tolerance of the folded state, in sheet units."""

TOLERANCE = 1e-4
"""A vertex this near a fold line lies on it; faces that overlap by less do not overlap.

The published results reproduce with anything from 3e-5 to 1e-3; larger ones let errors pile up.
"""
