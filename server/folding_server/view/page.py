"""The page as one self-contained HTML file: nothing in it comes from elsewhere, and its own policy says so."""

from functools import cache
from importlib.resources import files
from string import Template

from folding_schemas.model_view import ModelView

SCRIPTS = ("connection.js", "drawing.js", "picking.js", "page.js")
"""The scripts in the order in which they are run; each uses those before it."""


def page_html(view: ModelView | None = None, endpoint: str | None = None) -> str:
    """The page. Without a ``view`` it waits for one from an MCP host.

    ``endpoint`` is a path of the same server that answers tool calls; without one the page only shows.
    """
    data = "null" if view is None else view.model_dump_json()
    return Template(_asset("page.html")).substitute(
        style=_asset("style.css"),
        script="\n".join(_asset(name) for name in SCRIPTS),
        connect="'self'" if endpoint else "'none'",
        endpoint=endpoint or "",
        view=data.replace("<", "\\u003c"),
    )


@cache
def _asset(name: str) -> str:
    """The text of a file that the page is made of."""
    return files(__package__).joinpath("assets", name).read_text(encoding="utf-8")
