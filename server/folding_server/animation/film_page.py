"""A lesson as one HTML page that plays without a network: step buttons, words for those who do not see, no motion unasked."""

import json
from html import escape
from importlib.resources import files
from string import Template
from typing import Any

from folding_server.animation.film_camera import AMBIENT_PART, DISTANCE, EYE_TILT, LAYER_SHADE, LIGHT
from folding_server.animation.scenes import LAYER_GAP, FilmScene, extent_of, film_scenes
from folding_server.diagram.palette import colors_of, diagram_colors
from folding_server.geometry.graph import edge_of, sides
from folding_server.instructions.ink_colors import printed
from folding_server.instructions.moves import Lesson
from folding_server.instructions.step_scene import turned_edges

COORDINATE_DECIMALS = 5
"""Of coordinates in sheet units."""


def film_page(lesson: Lesson, words: list[str], language: str, view: str) -> str:
    """The page; ``words`` are those of the moves, and last those of the finished model."""
    program = lesson.program
    inks = printed(diagram_colors(colors_of(program.front_color, program.back_color)))
    data = {
        "words": [f"{number}. {text}" for number, text in enumerate(words, 1)],
        "scenes": [_scene(scene) for scene in film_scenes(lesson)],
        "front": inks.front,
        "back": inks.back,
        "tilt": EYE_TILT[view],
        "distance": DISTANCE,
        "gap": LAYER_GAP,
        "light": list(LIGHT),
        "ambient": AMBIENT_PART,
        "shade": LAYER_SHADE,
    }
    template = files(__package__).joinpath("film_page.html").read_text(encoding="utf-8")
    text = json.dumps(data, separators=(",", ":"), ensure_ascii=False).replace("<", "\\u003c")
    return Template(template).substitute(title=escape(program.name), language=language, data=text)


def _scene(scene: FilmScene) -> dict[str, Any]:
    """A movement as the page computes it: faces as they lie before it, with their layers before and after.

    Of the ``creases`` 1 is one that lies flat, 2 one about which the part turns, 0 any other edge.
    """
    before, after = scene.levels
    swing, paper = scene.swing, scene.after
    turned = set(turned_edges(swing)) if swing else set()
    faces = []
    for face in paper.order:
        start = swing.starts.get(face) if swing else None
        motion = start or (scene.before if swing is None else paper).isometries[face]
        corners = [motion(paper.vertices_coords[v]) for v in paper.faces[face]]
        cycle = paper.faces[face]
        pairs = (edge_of(u, v) for u, v in sides(cycle))
        faces.append(
            {
                "at": [[round(x, COORDINATE_DECIMALS), round(y, COORDINATE_DECIMALS)] for x, y in corners],
                "creases": [
                    1 if paper.edge_assignment(edge) == "F" else 2 if edge in turned else 0 for edge in pairs
                ],
                "moves": int(start is not None),
                "levels": [before[face], after[face]],
                "back": int(paper.back_up(face)),
            }
        )
    points = list(scene.before.folded_vertices_coords.values())
    return {
        "move": scene.move,
        "faces": faces,
        "line": list(swing.line) if swing else None,
        "over": int(swing is None or swing.over),
        "degrees": scene.degrees,
        "mean": [sum(x for x, _ in points) / len(points), sum(y for _, y in points) / len(points)],
        "middles": [list(middle) for middle in scene.middles],
        "extents": [extent_of(scene.before), extent_of(scene.after)],
    }
