"""How often a critic judges rightly: right and wrong states of sequences whose program is known, put before it."""
