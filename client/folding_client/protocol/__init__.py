"""The folding server over the Model Context Protocol: one connection, one run, every call on record."""
