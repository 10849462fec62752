"""Programs of others that speak MCP, run against our server: each in an environment of its own, with a pinned version."""
