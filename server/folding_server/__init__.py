"""The folding server: geometry, diagrams, photos and stored runs, offered as MCP tools. It calls no language model."""
