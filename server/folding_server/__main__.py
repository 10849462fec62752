"""``python -m folding_server``: the same as ``foldingagent-server``."""

from folding_server.cli import main

main()
