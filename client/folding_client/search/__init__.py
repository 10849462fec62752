"""The geometric search for a folding program, by frames, for the geometric model and for hybrids."""
