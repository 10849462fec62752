"""``python -m folding_client``: the command ``foldingagent``."""

from folding_client.cli import main

main()
