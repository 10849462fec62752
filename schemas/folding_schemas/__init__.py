"""What crosses the wire between the folding server and its hosts: typed with pydantic, free of logic."""
