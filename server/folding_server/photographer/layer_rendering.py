"""Painting the stack: faces bottom to top over the table, each with the shadow that it casts on what lies
below it, and parts that stand up with theirs on what is under them.

Painted at ``SAMPLES`` times the picture's resolution in the part of the picture around the paper.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from math import cos, radians, sin

import cv2
import numpy as np
from numpy.typing import NDArray

from folding_server.arrays import ByteMask, Float32s
from folding_server.photographer.color_spaces import floats
from folding_server.photographer.pinhole_camera import Matrix
from folding_server.photographer.placement import FaceGroup, PaperView
from folding_server.photographer.sheet_texture import SheetTexture
from folding_server.simulator.planes import plane_index, planes

SAMPLES = 3
SHADOW_ROOM = 0.08
"""Room around the paper for its shadows, in sheet sides."""
LIFT = 0.006
"""How far the edge of a flap stands off what is below it, in sheet sides."""
SOFTNESS = 0.12
"""How soft the shadow of a raised part is for each unit of its height."""
PLANES = 1000
"""More planes than a group has: what tells the planes of two groups apart."""
_SHIFT = 6


@dataclass(frozen=True)
class Shading:
    """How shadows fall: ``towards`` their direction in pixels (unit vector), ``depth`` 0 to 1, the lamp's
    ``azimuth`` on the table in degrees.
    """

    towards: tuple[float, float]
    depth: float
    azimuth: float


@dataclass(frozen=True)
class Window:
    """A part of the picture: left, top, right, bottom in pixels."""

    left: int
    top: int
    right: int
    bottom: int

    @property
    def area(self) -> tuple[slice, slice]:
        """Rows and columns of the picture."""
        return slice(self.top, self.bottom), slice(self.left, self.right)

    @property
    def samples(self) -> tuple[int, int]:
        """Rows and columns of the samples."""
        return (self.bottom - self.top) * SAMPLES, (self.right - self.left) * SAMPLES

    @property
    def pixel_to_sample(self) -> Matrix:
        """Affine map (3, 3) from pixels to samples whose centres are whole numbers."""
        s = SAMPLES
        return np.array([[s, 0, -s * self.left - 0.5], [0, s, -s * self.top - 0.5], [0, 0, 1.0]])


@dataclass(frozen=True)
class Canvas:
    """The samples being painted: linear ``albedo`` (r, c, 3), ``light`` (r, c) from 0 to 1 and the ``plane``
    on top.
    """

    window: Window
    albedo: Float32s
    light: Float32s
    plane: NDArray[np.int16]


def window_around(view: PaperView, size: tuple[int, int], unit: float) -> Window:
    """The part of the picture that the paper and its shadows can reach; ``unit`` pixels to a sheet side."""
    points = view.corners
    low = np.floor(points.min(0) - SHADOW_ROOM * unit).astype(int)
    high = np.ceil(points.max(0) + SHADOW_ROOM * unit).astype(int)
    left, top = (int(v) for v in np.clip(low, 0, np.array(size) - 1))
    right, bottom = (int(v) for v in np.clip(high, (left + 1, top + 1), size))
    return Window(left, top, right, bottom)


def shadow_direction(lamp_azimuth: float, roll: float) -> tuple[float, float]:
    """Direction in pixels of shadows under a lamp at an azimuth on the table (degrees)."""
    angle = radians(lamp_azimuth - roll)
    return -cos(angle), sin(angle)


def paint_stack(
    table: Float32s,
    view: PaperView,
    sheet: SheetTexture,
    shading: Shading,
    unit: float,
    tones: dict[int, float],
) -> tuple[Float32s, Float32s, ByteMask]:
    """The picture's albedo and light with the paper on it, and the coverage of the paper (0 to 255).

    ``table`` is the linear albedo of the bare table (rows, columns, 3); ``tones`` the brightness of each
    face, as faces do not lie quite level.
    """
    size = (table.shape[1], table.shape[0])
    window = window_around(view, size, unit)
    rows, cols = window.samples
    under = cv2.resize(table[window.area], (cols, rows), interpolation=cv2.INTER_LINEAR)
    canvas = Canvas(
        window, floats(under), np.ones((rows, cols), np.float32), np.full((rows, cols), -1, np.int16)
    )
    plane_of = plane_index(planes(view.paper))
    for number, group in enumerate(view.groups):
        if group.raised:
            _shade_below(canvas, view, group, shading, unit)
        else:
            _shade_table(canvas, view, shading, unit)
        for face in group.faces:
            plane = number * PLANES + plane_of[face]
            floor = number * PLANES if group.raised else -1
            light = tones[face] * view.brightness(face, shading.azimuth)
            _paint_face(canvas, view, sheet, shading, face, (plane, floor), light, unit)
    return _resolve(table, canvas)


def _resolve(table: Float32s, canvas: Canvas) -> tuple[Float32s, Float32s, ByteMask]:
    """Bring the samples back to the picture's resolution."""
    area = canvas.window.area
    shape = (area[1].stop - area[1].start, area[0].stop - area[0].start)
    albedo, light = table.copy(), np.ones(table.shape[:2], np.float32)
    coverage = np.zeros(table.shape[:2], np.uint8)
    lit = canvas.albedo * canvas.light[..., None]
    light[area] = cv2.resize(canvas.light, shape, interpolation=cv2.INTER_AREA)
    albedo[area] = cv2.resize(lit, shape, interpolation=cv2.INTER_AREA) / light[area][..., None]
    paper = (canvas.plane >= 0).astype(np.uint8) * np.uint8(255)
    coverage[area] = cv2.resize(paper, shape, interpolation=cv2.INTER_AREA)
    return albedo, light, coverage


def _paint_face(
    canvas: Canvas,
    view: PaperView,
    sheet: SheetTexture,
    shading: Shading,
    face: int,
    place: tuple[int, int],
    tone: float,
    unit: float,
) -> None:
    """Darken what the face shades, then lay the face itself.

    ``place`` is its plane, and the lowest plane that it lies close to.
    """
    to_sample = canvas.window.pixel_to_sample
    outline = _samples(canvas, view.outline(face))
    reach = int(np.ceil(LIFT * unit * SAMPLES * 3))
    box = _box(outline, canvas, reach)
    if box is None:
        return
    mask = _filled(outline, box)
    _cast(canvas, box, mask, shading, place, LIFT * unit * SAMPLES)
    motion = _offset(box) @ to_sample @ view.sheet_to_pixel(face) @ np.linalg.inv(sheet.sheet_to_texture)
    side = sheet.back if view.back_up(face) else sheet.front
    skin = cv2.warpPerspective(
        side, motion, mask.shape[::-1], flags=cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE
    )
    inside = mask > 0
    toned = floats(skin) * np.float32(tone)
    np.copyto(canvas.albedo[box], toned, where=inside[..., None])
    np.copyto(canvas.light[box], np.float32(1), where=inside)
    np.copyto(canvas.plane[box], np.int16(place[0]), where=inside)
    _rim(canvas, view, face, outline, box)


def _rim(canvas: Canvas, view: PaperView, face: int, outline: Matrix, box: tuple[slice, slice]) -> None:
    """A faint line where the face ends: cut edges and folded edges catch the light differently."""
    cycle = view.paper.faces[face]
    light = canvas.light[box]
    corner = np.array([box[1].start, box[0].start])
    points = np.rint((outline - corner) * 2**_SHIFT).astype(int)
    for i, v in enumerate(cycle):
        assignment = view.paper.edge_assignment((min(cycle[i - 1], v), max(cycle[i - 1], v)))
        if assignment != "F":
            mask = np.zeros(light.shape, np.uint8)
            cv2.line(mask, points[i - 1].tolist(), points[i].tolist(), 255, 2, cv2.LINE_8, _SHIFT)
            light[mask > 0] = 0.84 if assignment == "B" else 0.9


def _cast(
    canvas: Canvas,
    box: tuple[slice, slice],
    mask: ByteMask,
    shading: Shading,
    place: tuple[int, int],
    reach: float,
) -> None:
    """Soft shadow of a face on everything close under it but its own plane."""
    plane, floor = place
    soft = _moved_and_blurred(mask, shading, reach * 0.6, reach * 0.6)
    under = canvas.plane[box]
    other = (under != plane) & (under >= floor)
    shadow = np.where(other, 1 - np.float32(shading.depth / 255) * soft, np.float32(1))
    np.minimum(canvas.light[box], shadow, out=canvas.light[box])


def _shade_table(canvas: Canvas, view: PaperView, shading: Shading, unit: float) -> None:
    """The wider shadow of the whole model on the table, thrown further where the stack is higher."""
    whole = (slice(0, canvas.light.shape[0]), slice(0, canvas.light.shape[1]))
    silhouette = _silhouette(canvas, [view.outline(face) for face in view.groups[0].faces])
    height = LIFT * (1 + 0.25 * float(np.mean(list(view.level.values()))))
    soft = _moved_and_blurred(silhouette, shading, height * unit * SAMPLES, 1.6 * height * unit * SAMPLES)
    canvas.light[whole] = 1 - np.float32(0.9 * shading.depth / 255) * soft


def _shade_below(canvas: Canvas, view: PaperView, group: FaceGroup, shading: Shading, unit: float) -> None:
    """The shadow of a raised part on all that was painted before, softer where the part is higher."""
    silhouette = _silhouette(canvas, [view.shadow(face, shading.azimuth) for face in group.faces])
    blur = (LIFT + SOFTNESS * view.height(group)) * unit * SAMPLES
    soft = _moved_and_blurred(silhouette, shading, 0.0, blur)
    shadow = 1 - np.float32(0.9 * shading.depth / 255) * soft
    np.minimum(canvas.light, shadow, out=canvas.light)


def _silhouette(canvas: Canvas, outlines: Sequence[Matrix]) -> ByteMask:
    """Convex outlines (pixels) filled, in samples."""
    filled = np.zeros(canvas.light.shape, np.uint8)
    for outline in outlines:
        points = np.rint(_samples(canvas, outline) * 2**_SHIFT).astype(np.int32)
        cv2.fillConvexPoly(filled, points, 255, cv2.LINE_8, _SHIFT)
    return filled


def _moved_and_blurred(mask: ByteMask, shading: Shading, offset: float, blur: float) -> Float32s:
    """A mask moved along the throw of the shadow and blurred, 0 to 255."""
    dx, dy = shading.towards[0] * offset, shading.towards[1] * offset
    radius = max(int(blur), 1)
    small = cv2.warpAffine(mask, np.array([[1, 0, dx], [0, 1, dy]]), mask.shape[::-1])
    return floats(cv2.stackBlur(small, (2 * radius + 1, 2 * radius + 1)))


def _samples(canvas: Canvas, pixels: Matrix) -> Matrix:
    """Sample coordinates (n, 2) of pixels (n, 2)."""
    m = canvas.window.pixel_to_sample
    return np.asarray(pixels @ m[:2, :2].T + m[:2, 2])


def _box(outline: Matrix, canvas: Canvas, reach: int) -> tuple[slice, slice] | None:
    """Rows and columns of the samples within ``reach`` of an outline; None if there are none."""
    rows, cols = canvas.light.shape
    x0, y0 = np.floor(outline.min(0)).astype(int) - reach
    x1, y1 = np.ceil(outline.max(0)).astype(int) + reach + 1
    x0, y0, x1, y1 = max(x0, 0), max(y0, 0), min(x1, cols), min(y1, rows)
    return (slice(int(y0), int(y1)), slice(int(x0), int(x1))) if x0 < x1 and y0 < y1 else None


def _filled(outline: Matrix, box: tuple[slice, slice]) -> ByteMask:
    """The outline filled, in the samples of the box."""
    mask = np.zeros((box[0].stop - box[0].start, box[1].stop - box[1].start), np.uint8)
    points = np.rint((outline - [box[1].start, box[0].start]) * 2**_SHIFT).astype(np.int32)
    cv2.fillConvexPoly(mask, points, 255, cv2.LINE_8, _SHIFT)
    return mask


def _offset(box: tuple[slice, slice]) -> Matrix:
    """Affine map (3, 3) that moves the box's corner to the origin."""
    return np.array([[1, 0, -box[1].start], [0, 1, -box[0].start], [0, 0, 1.0]])
