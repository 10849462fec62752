"""Explaining a photo without a new crease: nothing happened, the model was turned, turned over, or unfolded."""

from collections.abc import Iterator, Sequence
from math import atan2, degrees

from folding_schemas.actions import Action, Flip, FlipAxis, Rotate, Unfold

from folding_server.errors import ActionRefused
from folding_server.geometry.isometry import IDENTITY, Isometry, turn
from folding_server.geometry.similarity import Similarity
from folding_server.simulator import apply
from folding_server.simulator.paper import Paper
from folding_server.vision.registration.alignment import Aligned, Freedom, align
from folding_server.vision.registration.scene import FaceStack, Scene, face_stack
from folding_server.vision.solver.plan import Plan

ROUND_ANGLES = 15.0
"""Rotations within ``ROUND_REACH`` degrees of a multiple of this are taken to be it; the rest is drift."""
ROUND_REACH = 5.0
"""Degrees within which a turn is taken to be a round one."""


def centered(stack: FaceStack, scene: Scene, motion: Similarity = IDENTITY) -> Similarity:
    """A motion followed by the shift that brings the stack's middle onto that of the paper in the photo."""
    x, y = motion(stack.center)
    cx, cy = scene.center
    return Isometry(1, 0, 0, 1, cx - x, cy - y).after(motion)


def best_turns(stack: FaceStack, scene: Scene, step: float = 5.0, keep: int = 3) -> list[Aligned]:
    """The alignments of the turns in the plane that explain a photo best, best first; ``step`` in degrees."""
    tried = []
    for k in range(int(360 / step)):
        angle = k * step if k * step <= 180 else k * step - 360
        motion = centered(_turned(stack, angle), scene, turn(angle, stack.center))
        tried.append((scene.agreement(stack, motion), angle, motion))
    tried.sort(key=lambda t: (-t[0], abs(t[1])))
    kept: list[tuple[float, Similarity]] = []
    for _, angle, motion in tried:
        if all(abs((angle - other + 180) % 360 - 180) > 12 for other, _ in kept):
            kept.append((angle, motion))
        if len(kept) == keep:
            break
    aligned = [align(stack, scene, m, Freedom(shift=0.04, turn=3.0, halvings=4)) for _, m in kept]
    return sorted(aligned, key=lambda a: -a.agreement)


def _turned(stack: FaceStack, angle: float) -> FaceStack:
    motion = turn(angle, stack.center)
    return FaceStack([[motion(p) for p in outline] for outline in stack.outlines], stack.backs)


def turned_plans(paper: Paper, scene: Scene, before: tuple[Action, ...], last: Similarity) -> Iterator[Plan]:
    """Rotations that explain the photo; ``last`` is the motion under which the paper explained the photo before."""
    stack = face_stack(paper)
    for aligned in best_turns(stack, scene):
        relative = _angle_of(aligned.motion) - _angle_of(last)
        rounded = rounded_angle((relative + 180) % 360 - 180)
        if rounded == 0:
            continue
        action = Rotate(angle=rounded)
        after = apply(paper, action)
        start = centered(face_stack(after), scene, last)
        settled = align(face_stack(after), scene, start, Freedom(shift=0.03, turn=3.0, halvings=4))
        yield Plan(
            (*before, action),
            "rotate" if not before else "compound",
            after,
            settled.motion,
            settled.agreement,
            f"the model was turned by {rounded:g} degrees clockwise",
        )


def _angle_of(motion: Similarity) -> float:
    """The clockwise angle of a rotation in degrees."""
    return degrees(atan2(motion.b, motion.a))


def rounded_angle(angle: float) -> float:
    """A round angle if one is near, else whole degrees."""
    nearest = round(angle / ROUND_ANGLES) * ROUND_ANGLES
    return nearest if abs(nearest - angle) <= ROUND_REACH else float(round(angle))


def flip_plans(paper: Paper, scene: Scene, last: Similarity) -> Iterator[Plan]:
    """Flips about each axis, and a flip about x with the turn that fits best."""
    axes: Sequence[FlipAxis] = ("x", "y", "y=x", "y=-x")
    for axis in axes:
        action = Flip(axis=axis)
        after = apply(paper, action)
        stack = face_stack(after)
        settled = align(stack, scene, centered(stack, scene, last), Freedom(shift=0.04, turn=4.0, halvings=4))
        yield Plan(
            (action,),
            "flip",
            after,
            settled.motion,
            settled.agreement,
            f"the model was turned over about {axis}",
        )
    first = Flip(axis="x")
    yield from turned_plans(apply(paper, first), scene, (first,), last)


def unfold_plans(paper: Paper, scene: Scene, motions: Sequence[Similarity]) -> Iterator[Plan]:
    """Each fold undone, and each pair of folds."""
    singles = list(each_unfolding(paper))
    for action, after in singles:
        yield _settled((action,), "unfold", after, scene, motions)
    seen: set[frozenset[object]] = set()
    for action, after in singles:
        for second, final in each_unfolding(after):
            key = frozenset(final.creases.items())
            if key not in seen:
                seen.add(key)
                yield _settled((action, second), "compound", final, scene, motions)


def each_unfolding(paper: Paper) -> Iterator[tuple[Unfold, Paper]]:
    """Each way to undo one fold: the action and the paper after it."""
    numbers = sorted({record.fold for e, record in paper.creases.items() if paper.is_folded(e)}, reverse=True)
    for i, number in enumerate(numbers):
        edge = min(e for e, record in paper.creases.items() if record.fold == number and paper.is_folded(e))
        action = Unfold() if i == 0 else Unfold(edge=edge)
        try:
            yield action, apply(paper, action)
        except ActionRefused:
            continue


def _settled(
    actions: tuple[Action, ...], kind: str, after: Paper, scene: Scene, motions: Sequence[Similarity]
) -> Plan:
    """The plan of some actions under the best of the motions, aligned."""
    stack = face_stack(after)
    start = max(motions, key=lambda m: scene.agreement(stack, m))
    settled = align(stack, scene, start, Freedom(shift=0.03, turn=3.0, halvings=4))
    return Plan(
        actions,
        "unfold" if kind == "unfold" else "compound",
        after,
        settled.motion,
        settled.agreement,
        "a crease was unfolded" if len(actions) == 1 else "two creases were unfolded",
    )
