"""What the tools share: replayed papers, observed photos, images and words for an answer."""
