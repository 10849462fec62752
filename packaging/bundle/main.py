"""Start the server in a bundle of Claude Desktop, which hands over the folders of photos that its user chose."""

import sys

from folding_server.cli import main


def options(words: list[str]) -> list[str]:
    """The server's options for the folders; a placeholder is what is left where no folder was chosen."""
    chosen = [word for word in words if word and not word.startswith("${")]
    return [option for folder in chosen for option in ("--sequences", folder)]


if __name__ == "__main__":
    main(options(sys.argv[1:]))
