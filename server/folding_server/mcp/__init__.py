"""The Model Context Protocol: the server, its tools, resources and prompts, over stdio and HTTP."""
