"""Seeing paper in photos: segmentation, pose, comparison with a folded state, and solving for what was done."""
