"""The table of what the solver weighs, in ``docs/solver.md``, made from the weights themselves.

``PYTHONPATH=tests python tests/contract/evidence_table.py`` writes it anew.
"""

from pathlib import Path

from folding_server.vision.evidence import terms

FILE = Path(__file__).resolve().parents[2] / "docs" / "solver.md"
BEGIN, END = "<!-- evidence: begin -->\n", "<!-- evidence: end -->\n"


def table() -> str:
    """All terms as a table of Markdown."""
    rows = ["| term | weight | per | what it says | source |", "|---|---|---|---|---|"]
    rows += [f"| `{t.name}` | {t.weight:g} | {t.unit} | {t.words} | {t.source} |" for t in terms().values()]
    return "\n".join(rows) + "\n"


def page(text: str) -> str:
    """The page with the table as it should be."""
    head, _, rest = text.partition(BEGIN)
    return head + BEGIN + table() + END + rest.partition(END)[2]


if __name__ == "__main__":
    FILE.write_text(page(FILE.read_text(encoding="utf-8")), encoding="utf-8")
