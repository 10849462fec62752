"""Geometry of the plane that every room uses: pure functions on plain tuples and arrays. Lengths in sheet units."""
