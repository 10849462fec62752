"""The tools of the server, one thin module per family: check parameters, call another package, wrap the result."""
