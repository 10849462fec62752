"""What was done between states that are given as files: the actions of each step, replayed to the state."""
