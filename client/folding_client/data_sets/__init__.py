"""Data sets of other people as sequences with truth."""
