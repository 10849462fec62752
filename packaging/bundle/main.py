"""Start the server in a bundle of Claude Desktop, which hands over the folders that its user chose."""

import sys

from folding_server.cli import main

ALLOW = "--allow"
"""Stands between the folders of sequences and those of films."""


def options(words: list[str]) -> list[str]:
    """The server's options for the folders; a placeholder is what is left where no folder was chosen."""
    chosen = [word for word in words if word and not word.startswith("${")]
    split = chosen.index(ALLOW) if ALLOW in chosen else len(chosen)
    named = [("--sequences", folder) for folder in chosen[:split]]
    named += [(ALLOW, folder) for folder in chosen[split + 1 :]]
    return [word for option in named for word in option]


if __name__ == "__main__":
    main(options(sys.argv[1:]))
