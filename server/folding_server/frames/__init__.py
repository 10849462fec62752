"""Sequences of photos: manifests, images in any state phones leave them in, filmstrips, panels, video."""
