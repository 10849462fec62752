"""The page of all numbers that seeing and solving decide by, ``docs/solver_numbers.md``, read from the sources.

``PYTHONPATH=tests python tests/contract/vision_numbers.py`` writes it anew. A number is a constant of a module in capitals; what it
means, and its unit, stand in the text below it.
"""

import ast
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
FILE = ROOT / "docs" / "solver_numbers.md"
SOURCES = ROOT / "server" / "folding_server" / "vision"
LABELS = {"BACKGROUND", "FRONT", "BACK", "UNKNOWN", "OUTLINE", "LAYER", "SEEN", "WRONG"}
HEAD = """\
# The numbers of seeing and solving

Made from the sources by `PYTHONPATH=tests python tests/contract/vision_numbers.py`; a test fails when it is not up to date. What plans are
weighed by, with the source of each weight, is in [solver.md](solver.md). The numbers here were chosen on photographs of the development
seeds, 1 to 30, unless their text says otherwise; none was fitted automatically. Lengths are in sheet units where no other unit is given."""


def page() -> str:
    """The whole page."""
    parts = [HEAD]
    for path in sorted(SOURCES.rglob("*.py")):
        if rows := list(_numbers(ast.parse(path.read_text(encoding="utf-8")).body)):
            table = ["| number | value | meaning |", "|---|---|---|", *rows]
            parts += [f"## `{path.relative_to(SOURCES)}`", "\n".join(table)]
    return "\n\n".join(parts) + "\n"


def _numbers(body: list[ast.stmt]) -> Iterator[str]:
    """A row for each constant that holds numbers; those without a text of their own share the one that follows."""
    for statement, after in zip(body, [*body[1:], None], strict=True):
        if (
            isinstance(statement, ast.Assign)
            and _holds_numbers(statement.value)
            and not _names_things(statement)
        ):
            names = ", ".join(f"`{ast.unparse(target).strip('()')}`" for target in statement.targets)
            value = ast.unparse(statement.value)
            yield f"| {names} | {value} | {_text(after)} |"


def _names_things(statement: ast.Assign) -> bool:
    """Whether the numbers only name things: the classes of a label image, the colours of an overlay."""
    return bool(
        LABELS & {name.strip() for t in statement.targets for name in ast.unparse(t).strip("()").split(",")}
    )


def _holds_numbers(value: ast.expr) -> bool:
    """Whether an expression is a number, or several."""
    if isinstance(value, ast.Tuple):
        return all(map(_holds_numbers, value.elts))
    if isinstance(value, ast.UnaryOp):
        return _holds_numbers(value.operand)
    return isinstance(value, ast.Constant) and isinstance(value.value, int | float)


def _text(statement: ast.stmt | None) -> str:
    """The text below a constant as one line."""
    if isinstance(statement, ast.Expr) and isinstance(statement.value, ast.Constant):
        return " ".join(str(statement.value.value).split()).replace("|", "\\|")
    return ""


if __name__ == "__main__":
    FILE.write_text(page(), encoding="utf-8")
