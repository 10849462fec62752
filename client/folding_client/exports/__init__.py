"""Recorded runs in the formats of other people's viewers. Their packages are extras, loaded where an export needs them."""
