"""The tool surface as a contract."""
