"""Entering this server into the configuration files of MCP hosts."""
