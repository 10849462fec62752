"""The tools of the server, one thin module per family: check arguments, call the room, wrap the answer."""
