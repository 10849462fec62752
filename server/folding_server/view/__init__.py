"""The page that shows a model: what it is given, the one HTML file, and serving it to a browser without a host."""
