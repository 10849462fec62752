"""Laying drawn paper over a photo: one objective and one renderer, and the searches that share them.

``scene`` draws layered polygons and measures agreement (the objective). ``alignment`` is a pattern search followed by
Levenberg-Marquardt from a start; ``chamfer_matching`` finds starts by edges, ``edge_icp`` ends to a fraction of a pixel by pulling
edges. ``paper_alignment`` is the door for a comparison: the best small motion from nothing known. Cameras other than the
first photo's are ``vision.pose_estimation``'s, which draws and pulls with the same parts.
"""
