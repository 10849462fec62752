"""The photographer: photo-like keyframes of a folding program, with the truth beside them."""

from folding_server.photographer.photographing import PhotographResult, photograph

__all__ = ["PhotographResult", "photograph"]
