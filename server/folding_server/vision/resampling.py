"""A picture on one grid, seen on another: no pixel moves, however the sizes of the two round."""

from math import ceil

import cv2
import numpy as np

from folding_server.arrays import Image, RgbImage
from folding_server.vision.grid import Grid


def resampled(image: RgbImage | Image, old: Grid, new: Grid) -> RgbImage | Image:
    """An image (rows, cols) or (rows, cols, channels) of a grid on another over the same plane.

    Coarser pixels are the mean of what they cover; outside the old grid the nearest value is taken.
    """
    times = max(1, ceil(old.pixels_per_unit / new.pixels_per_unit - 1e-6))
    fine = Grid(new.left, new.top, new.pixels_per_unit * times, new.rows * times, new.cols * times)
    back = (old.matrix() @ np.linalg.inv(fine.matrix()))[:2]
    image = cv2.warpAffine(
        image,
        back,
        (fine.cols, fine.rows),
        flags=cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP,
        borderMode=cv2.BORDER_REPLICATE,
    )
    if times > 1:
        image = cv2.resize(image, (new.cols, new.rows), interpolation=cv2.INTER_AREA)
    return image
