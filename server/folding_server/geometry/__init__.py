"""Geometry of the plane that every package uses: pure functions on plain tuples and arrays. Lengths in sheet units."""
