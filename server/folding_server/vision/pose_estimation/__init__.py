"""Where the camera of one photo stood, told by the folded paper that the photo may show."""
