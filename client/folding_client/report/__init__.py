"""A static site that shows recorded runs: an overview of all, and a page for each."""
