"""Icons of tools, resources and prompts: line drawings that travel within the lists as data URLs."""

from urllib.parse import quote

from mcp.types import Icon


def _icon(path: str) -> Icon:
    """A drawing on 8 by 8 units from the ``d`` of an SVG path, filled where paper is."""
    svg = f"<svg xmlns='http://www.w3.org/2000/svg' viewBox='0,0,8,8'><path d='{path}'/></svg>"
    return Icon(src=f"data:image/svg+xml,{quote(svg, safe=_AS_THEY_ARE)}")


_AS_THEY_ARE = "'=:/,"
"""Characters that need no escape in a data URL."""

RUN_ICON = _icon("M1,1h6v6H1z")
ACTION_ICON = _icon("M1,7V1l6,6z")
PHOTO_ICON = _icon("M1,2h6v4H1zM4,3v2")
CHECKPOINT_ICON = _icon("M2,1h4v6L4,5,2,7z")
CHECK_ICON = _icon("M1,4l2,2,4-4v2L3,8,1,6z")
FILE_ICON = _icon("M2,1h3l1,2v4H2z")
