"""What a tool's picture shows, in words: a newer picture with the same words makes an older one
superfluous.
"""

from collections.abc import Mapping
from typing import Any

_CRITIC_GRID = (
    "photo of frame {before}",
    "photo of frame {frame}",
    "diagram of frame {before}",
    "diagram of the candidate for frame {frame}",
)


def subject_of(tool: str, arguments: Mapping[str, Any], index: int) -> str:
    """The subject of the picture at ``index`` in a tool's answer."""
    frame = arguments.get("frame")
    of_attempt = f" of attempt {arguments['attempt']}" if arguments.get("attempt") else ""
    subjects = {
        "view_frame": f"photo of frame {frame}",
        "observe_movement": f"filmstrip up to frame {frame}",
        "render_current": "diagram of the current state",
        "list_attempts": f"diagram of attempt {index + 1}",
        "compare_to_frame": f"overlay{of_attempt} on the photo of frame {frame}",
        "generate_checkpoint_overview": "overview of the checkpoints",
    }
    if tool == "critic_grid" and isinstance(frame, int) and index < len(_CRITIC_GRID):
        return _CRITIC_GRID[index].format(before=frame - 1, frame=frame)
    return subjects.get(tool, f"picture {index + 1} of {tool}")
