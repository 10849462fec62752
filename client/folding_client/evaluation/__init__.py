"""Recorded runs against the truth: the paper's metrics on states that the server has measured, tables, curves."""
