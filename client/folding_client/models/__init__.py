"""Models behind one small interface: litellm, scripted, geometric."""
