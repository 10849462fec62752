"""Random folding programs, honest ones and near-degenerate ones, drawn action by action on the paper they make.

A plan is a generator of a few actions; it is sent the paper after each one, and dropped when one is refused.
"""

from collections.abc import Callable, Generator
from math import dist, hypot
from random import Random

from folding_schemas.actions import Action, AddVertex, Flip, FlipAxis, Fold, Rotate, Unfold
from folding_server.geometry.graph import Edge
from folding_server.simulator import TOLERANCE, Paper

Plan = Generator[Action, Paper, None]

AXES: tuple[FlipAxis, ...] = ("x", "y", "y=x", "y=-x")
NEAR = (1e-4, 3e-5, 1e-6)
"""Distances, in sheet units or as fractions of an edge, of points that almost coincide."""
ODD_FRACTIONS = (0.0, 1.0, -0.2, 1e-9, 1e-5, 0.99999)


def between_folds(random: Random, paper: Paper) -> Plan:
    """What a folder does between two folds: often nothing, else turn, flip, mark or open up."""
    draw = random.random()
    if draw < 0.15:
        yield Rotate(angle=random.choice([45.0, -45.0, 90.0, 180.0, 22.5, random.uniform(-360, 360)]))
    elif draw < 0.3:
        yield Flip(axis=random.choice(AXES))
    elif draw < 0.38:
        yield AddVertex(edge=any_edge(random, paper), position=fraction(random))
    elif draw < 0.42:
        yield AddVertex(edge=any_edge(random, paper), position=random.choice(ODD_FRACTIONS))
    elif draw < 0.52:
        yield Unfold()
    elif draw < 0.65:
        yield Unfold(edge=random.choice(folded_edges(paper) or [any_edge(random, paper)]))


def next_fold(random: Random, paper: Paper) -> Plan:
    """One fold with the points it needs."""
    plans = [plan for plan, weight in FOLDS.items() for _ in range(weight)]
    return random.choice(plans)(random, paper)


def boundary_fold(random: Random, paper: Paper) -> Plan:
    """A fold through two new points of the sheet's outline."""
    outline = [edge for edge, letter in paper.edges() if letter == "B"]
    return marked_fold(random, random.choice(outline), random.choice(outline))


def vertex_fold(random: Random, paper: Paper) -> Plan:
    """A fold through two vertices that exist, wherever they lie."""
    u, v = random.sample(sorted(paper.vertices_coords), 2)
    yield through(random, u, v)


def flap_fold(random: Random, paper: Paper) -> Plan:
    """A fold through two new points of one of the topmost faces."""
    return face_fold(random, paper, random.choice(paper.order[-3:]))


def inner_fold(random: Random, paper: Paper) -> Plan:
    """A fold through two new points of any face, buried or not."""
    return face_fold(random, paper, random.choice(paper.order))


def face_fold(random: Random, paper: Paper, face: int) -> Plan:
    """A fold through new points on two sides of a face."""
    cycle = paper.faces[face]
    sides = list(zip(cycle, (*cycle[1:], cycle[0]), strict=True))
    return marked_fold(random, *random.sample(sides, 2))


def marked_fold(random: Random, first: Edge, second: Edge) -> Plan:
    """New points on two edges, then a fold through them."""
    paper = yield AddVertex(edge=first, position=fraction(random))
    point = newest(paper)
    paper = yield AddVertex(
        edge=second if {*first} != {*second} else (first[0], point), position=fraction(random)
    )
    yield through(random, point, newest(paper))


def twin_fold(random: Random, paper: Paper) -> Plan:
    """Two points of an edge about a tolerance apart, and a fold through one of them, or even through both."""
    u, v = any_edge(random, paper)
    others = [w for w in paper.vertices_coords if w not in (u, v)]
    paper = yield AddVertex(edge=(u, v), position=fraction(random))
    point = newest(paper)
    apart = TOLERANCE * random.uniform(0.9, 3) / max(side_length(paper, (point, v)), TOLERANCE)
    paper = yield AddVertex(edge=(point, v), position=min(apart, 1.0))
    twin = newest(paper)
    yield through(
        random, *random.choice([(point, random.choice(others)), (twin, random.choice(others)), (point, twin)])
    )


def almost_alike(random: Random, paper: Paper) -> Plan:
    """A fold through almost the same fraction of two edges: almost parallel to what such folds made before."""
    first, second = any_edge(random, paper), any_edge(random, paper)
    place = random.choice([0.5, 0.25, 1 / 3, 0.75])
    paper = yield AddVertex(edge=first, position=place)
    point = newest(paper)
    other = second if {*first} != {*second} else (first[0], point)
    paper = yield AddVertex(edge=other, position=place + random.choice(NEAR) * random.uniform(-1, 1))
    yield through(random, point, newest(paper))


def echo_fold(random: Random, paper: Paper) -> Plan:
    """A fold through a new point that almost coincides with vertices of other layers, and maybe through two such."""
    paper = yield from echo(random, paper)
    point = newest(paper)
    if random.random() < 0.5:
        paper = yield from echo(random, paper)
    others = [w for w in paper.vertices_coords if w != point]
    yield through(random, point, random.choice([newest(paper), random.choice(others)]))


def echo(random: Random, paper: Paper) -> Generator[Action, Paper, Paper]:
    """A new point of an edge within NEAR of where a vertex lies that is none of its ends; a plain one if there is none."""
    edges, vertices = sorted(paper.edge_faces), sorted(paper.vertices_coords)
    for _ in range(40):
        edge, vertex = random.choice(edges), random.choice(vertices)
        foot = foot_fraction(paper, edge, vertex)
        if vertex not in edge and 0.01 < foot < 0.99 and off_line(paper, edge, vertex) < 10 * TOLERANCE:
            shift = random.choice(NEAR) * random.uniform(-1, 1) / side_length(paper, edge)
            return (yield AddVertex(edge=edge, position=foot + shift))
    return (yield AddVertex(edge=any_edge(random, paper), position=fraction(random)))


def almost_through(random: Random, paper: Paper) -> Plan:
    """A fold through a point that almost coincides with a vertex: the line just misses the vertex."""
    u, v = any_edge(random, paper)
    others = [w for w in paper.vertices_coords if w != u]
    paper = yield AddVertex(edge=(u, v), position=random.choice(NEAR) * random.uniform(0.5, 5))
    yield through(random, newest(paper), random.choice(others))


def almost_along(random: Random, paper: Paper) -> Plan:
    """A fold that almost coincides with a diagonal of a face: it leaves a sliver."""
    cycle = paper.faces[random.choice(paper.order)]
    k = random.randrange(len(cycle))
    u, v, w = cycle[k - 2], cycle[k - 1], cycle[k]
    paper = yield AddVertex(edge=(v, w), position=random.choice(NEAR) * random.uniform(0.5, 5))
    yield through(random, u, newest(paper))


def rounded_fold(random: Random, paper: Paper) -> Plan:
    """A fold through a vertex and its foot on an edge, the fraction rounded as people write it."""
    edges, vertices = sorted(paper.edge_faces), sorted(paper.vertices_coords)
    for _ in range(20):
        edge, vertex = random.choice(edges), random.choice(vertices)
        foot = foot_fraction(paper, edge, vertex)
        if vertex not in edge and 0.01 < foot < 0.99:
            paper = yield AddVertex(edge=edge, position=round(foot, random.randint(3, 7)))
            yield through(random, newest(paper), vertex)
            return


def repeated_fold(random: Random, paper: Paper) -> Plan:
    """A fold along an edge that exists."""
    yield through(random, *any_edge(random, paper))


FOLDS: dict[Callable[[Random, Paper], Plan], int] = {
    boundary_fold: 5,
    vertex_fold: 5,
    flap_fold: 3,
    inner_fold: 3,
    twin_fold: 2,
    almost_through: 2,
    almost_along: 1,
    almost_alike: 2,
    echo_fold: 3,
    rounded_fold: 3,
    repeated_fold: 1,
}
"""The ways to fold with their weights: about two folds in five are near-degenerate."""


def through(random: Random, u: int, v: int) -> Fold:
    """A fold through two vertices in either direction."""
    return Fold(edge=(u, v), direction=random.choice((1, -1)))


def newest(paper: Paper) -> int:
    """The id of the vertex made last."""
    return max(paper.vertices_coords)


def any_edge(random: Random, paper: Paper) -> Edge:
    """Any edge, either way round."""
    u, v = random.choice(sorted(paper.edge_faces))
    return (u, v) if random.random() < 0.5 else (v, u)


def fraction(random: Random) -> float:
    """A fraction of an edge: a common one, a rounded one, or any."""
    return random.choice(
        [
            0.5,
            0.25,
            1 / 3,
            0.75,
            round(random.uniform(0.02, 0.98), 3),
            random.uniform(0.001, 0.999),
            random.uniform(0.02, 0.98),
        ]
    )


def folded_edges(paper: Paper) -> list[Edge]:
    """The creases that are folded now."""
    return [edge for edge, letter in paper.edges() if letter in "MV"]


def side_length(paper: Paper, edge: Edge) -> float:
    """The length of an edge on the sheet."""
    return dist(paper.vertices_coords[edge[0]], paper.vertices_coords[edge[1]])


def off_line(paper: Paper, edge: Edge, vertex: int) -> float:
    """How far from the line of an edge the folded position of a vertex lies; the edge must have length."""
    (ax, ay), (bx, by) = paper.folded_vertices_coords[edge[0]], paper.folded_vertices_coords[edge[1]]
    x, y = paper.folded_vertices_coords[vertex]
    return abs((bx - ax) * (y - ay) - (by - ay) * (x - ax)) / hypot(bx - ax, by - ay)


def foot_fraction(paper: Paper, edge: Edge, vertex: int) -> float:
    """Where on an edge, as a fraction, the folded position of a vertex projects; -1 for an edge without length."""
    (ax, ay), (bx, by) = paper.folded_vertices_coords[edge[0]], paper.folded_vertices_coords[edge[1]]
    x, y = paper.folded_vertices_coords[vertex]
    length = hypot(bx - ax, by - ay)
    if length < 1e-9:
        return -1.0
    return ((x - ax) * (bx - ax) + (y - ay) * (by - ay)) / length**2
