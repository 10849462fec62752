"""Solving for the actions behind a photo, by analysis and synthesis."""
