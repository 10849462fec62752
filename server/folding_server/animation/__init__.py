"""Folding in motion: flaps that swing about their creases in space, as films and as a page to step through."""
