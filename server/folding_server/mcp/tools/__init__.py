"""The tools of the server, one thin module per family: check parameters, call the room, wrap the result."""
