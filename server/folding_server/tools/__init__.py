"""The tools of the server, one module per family, each thin: check the arguments, call the room, wrap the answer."""
