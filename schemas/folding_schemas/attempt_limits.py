"""What both sides know of the attempts at a frame beside the tools: how many there may be, and which cost none."""

MOST_ATTEMPTS = 20
"""The most attempts that a frame may be allowed from one state: four times as many as the paper's agent has."""

TECHNICAL_RETURN = "foldingagent/technical-return"
"""The key in the ``_meta`` of a ``restore_checkpoint`` call under which a client may say true.

The actions that are given up then cost no attempt: the client goes back because a model's reply was cut off or could not
be read, not because the result was wrong. It stands in the ``_meta``, which a client writes, since a model, which
writes the arguments, would have attempts for nothing by it.
"""
