"""A model in memory that the page's tool calls change, for people without an MCP host: nothing recorded is touched."""

from collections.abc import Callable, Mapping
from typing import Any

from folding_schemas.actions import Action, Actions, Fold, Program, Unfold
from folding_schemas.model_view import ModelView
from pydantic import ValidationError

from folding_server.errors import FoldingError, RunError
from folding_server.mcp.services.replay_cache import ReplayCache
from folding_server.mcp.tools.apps import VIEW_KEY
from folding_server.view.stops import ViewWindow, model_shown, model_view, program_window

FindPhotos = Callable[[ViewWindow], dict[int, str]]
"""The photos by keyframe, each filling a square of the table plane."""

ToolAnswer = dict[str, Any]
"""A call's answer as MCP has it: ``content``, ``isError``, ``_meta``."""


class LocalModel:
    """A program and the actions that were tried after it, each a step of its own. One caller at a time."""

    def __init__(self, program: Program, photos: FindPhotos | None = None) -> None:
        self._program = program
        self._tried: tuple[Action, ...] = ()
        self._find_photos = photos
        self._found: tuple[ViewWindow, dict[int, str]] | None = None
        self._replays = ReplayCache()

    @property
    def program(self) -> Program:
        """The program as it was given."""
        return self._program

    def photos(self) -> dict[int, str]:
        """The photos of the program's keyframes as data URLs; none where it has none. FoldingError if it cannot be folded."""
        return self._photos_in(program_window(self._program, self._replays))

    def view(self) -> ModelView:
        """What the page shows now. FoldingError if the program cannot be folded."""
        steps: tuple[Actions, ...] = (*self._program.steps, *((action,) for action in self._tried))
        program = self._program.model_copy(update={"steps": steps})
        return model_view(program, self._replays, self._photos_in(program_window(program, self._replays)))

    def call(self, name: str, arguments: Mapping[str, Any]) -> ToolAnswer:
        """The answer to ``show_model``, ``fold``, ``unfold`` or ``undo``; a refusal changes nothing."""
        try:
            return self._answer(name, arguments)
        except FoldingError as error:
            return _said(str(error), is_error=True)
        except ValidationError as error:
            first = error.errors()[0]
            where = ".".join(map(str, first["loc"]))
            return _said(f"{name} was called with a wrong {where}: {first['msg']}.", is_error=True)

    def _answer(self, name: str, arguments: Mapping[str, Any]) -> ToolAnswer:
        match name:
            case "show_model":
                view = self.view()
                meta = {VIEW_KEY: view.model_dump(mode="json")}
                return {**_said(model_shown(view).summary), "_meta": meta}
            case "fold":
                return self._tried_too(Fold.model_validate({**arguments}))
            case "unfold":
                return self._tried_too(Unfold.model_validate({**arguments}))
            case "undo":
                return self._undo()
        raise RunError(f"There is no tool {name!r} here; there are show_model, fold, unfold and undo.")

    def _tried_too(self, action: Action) -> ToolAnswer:
        from folding_server.diagram.strip import describe_action

        done = tuple(each for step in self._program.steps for each in step)
        self._replays.after(self._program.sheet, (*done, *self._tried, action))
        self._tried = (*self._tried, action)
        return _said(f"Done: {describe_action(action)}.")

    def _undo(self) -> ToolAnswer:
        if not self._tried:
            raise RunError("Nothing was folded here yet; the program itself stays as it is.")
        self._tried = self._tried[:-1]
        return _said("Took back the last action.")

    def _photos_in(self, window: ViewWindow) -> dict[int, str]:
        """The photos for a window, made again only when it has changed."""
        if self._find_photos is None:
            return {}
        if self._found is None or self._found[0] != window:
            self._found = window, self._find_photos(window)
        return self._found[1]


def _said(text: str, *, is_error: bool = False) -> ToolAnswer:
    return {"content": [{"type": "text", "text": text}], "isError": is_error}
