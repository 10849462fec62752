"""The light client: drives a vision-language model, or a geometric search, through the folding server's MCP
tools.
"""
