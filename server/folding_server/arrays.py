"""Names for numpy's arrays by the type of their elements; a docstring that mentions one says its shape."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
"""Coordinates, lengths, weights."""

Float32s = NDArray[np.float32]
"""Brightness and colour of pixels, where 24 bits are enough and half the memory counts."""

Ints = NDArray[np.int_]
"""Whole numbers: counts, labels, signs."""

Indices = NDArray[np.intp]
"""Indices into other arrays, as numpy and shapely return them."""

Bools = NDArray[np.bool_]
"""True or False for each element."""

Mask = Bools
"""True or False for each pixel, (height, width)."""

Geometries = NDArray[Any]
"""Shapely geometries; shapely's stubs know no narrower type of their arrays."""

Image = Float32s
"""A picture in floats, (height, width) or (height, width, channels)."""

RgbImage = NDArray[np.uint8]
"""An RGB picture, (height, width, 3), 0 to 255."""

ByteMask = NDArray[np.uint8]
"""A mask in bytes, as OpenCV takes and makes them, (height, width): 0 where not, up to 255 where wholly."""
