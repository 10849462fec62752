"""What the pictures of answers show, in words. A picture of the same thing has the same words wherever it is shown."""

from folding_schemas.pictures import PictureMeta


def photo_of(frame: int) -> PictureMeta:
    """The photo of a keyframe."""
    return PictureMeta(subject=f"photo of frame {frame}", frame=frame, role="photo")


def filmstrip_to(frame: int) -> PictureMeta:
    """The movement that leads to a keyframe."""
    return PictureMeta(subject=f"filmstrip up to frame {frame}", frame=frame, role="filmstrip")


def diagram_of_frame(frame: int) -> PictureMeta:
    """The saved state of a keyframe."""
    return PictureMeta(subject=f"diagram of frame {frame}", frame=frame, role="diagram")


def diagram_of_candidate(frame: int) -> PictureMeta:
    """The current state as a candidate for a keyframe."""
    return PictureMeta(subject=f"diagram of the candidate for frame {frame}", frame=frame, role="diagram")


def diagram_of_attempt(frame: int, attempt: int, state: int | None = None) -> PictureMeta:
    """The state that an attempt at a keyframe came to last, or an earlier one."""
    earlier = f", state {state}" if state else ""
    return PictureMeta(subject=f"diagram of attempt {attempt}{earlier}", frame=frame, role="diagram")


def diagram_of_current_state() -> PictureMeta:
    """The current state, of whatever frame it may become."""
    return PictureMeta(subject="diagram of the current state", role="diagram")


def overlay_on(frame: int, attempt: int | None, state: int | None = None) -> PictureMeta:
    """The current state, or what an attempt came to, drawn over the photo of a keyframe."""
    of_attempt = f" of attempt {attempt}{f', state {state}' if state else ''}" if attempt else ""
    return PictureMeta(
        subject=f"overlay{of_attempt} on the photo of frame {frame}", frame=frame, role="overlay"
    )


def overview_of_checkpoints() -> PictureMeta:
    """Photos and saved states of all keyframes."""
    return PictureMeta(subject="overview of the checkpoints", role="overview")


def contact_sheet_of_sequence(name: str) -> PictureMeta:
    """The keyframes of a sequence among images between them."""
    return PictureMeta(subject=f"contact sheet of the sequence {name}", role="overview")


def exported_diagram() -> PictureMeta:
    """The current state as a file."""
    return PictureMeta(subject="exported diagram of the current state", role="diagram")


def instructions_of(step: int | None) -> PictureMeta:
    """One step of the instructions to the run's model, or all."""
    subject = f"instructions, step {step}" if step else "instructions, all steps"
    return PictureMeta(subject=subject, role="diagram" if step else "overview")


def states_of_program() -> PictureMeta:
    """The states of a program that is tried."""
    return PictureMeta(subject="states of the program", role="overview")
