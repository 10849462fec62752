"""Laying a stack of folded faces on a photo: what it would look like there, and the motion that fits best."""
