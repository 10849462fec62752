"""What is said where a server may read no files of its user's own."""

ALLOWING = (
    "This server may read no films or photos by their paths; start it with --allow and the folder that holds them, "
    "then add_sequence makes a sequence of them."
)
