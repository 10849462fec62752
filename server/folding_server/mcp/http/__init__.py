"""Serving over Streamable HTTP: where to listen, under which names, with which connections, until when."""
