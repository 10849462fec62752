"""Names for calls, so that one that may have been lost can be sent again and is carried out once."""

REQUEST_ID = "foldingagent/request-id"
"""The key in the ``_meta`` of a tool call under which a client may send a UUID that it made for this call.

A call that changes a run and is sent again with the same id is answered as it was the first time. The same id
with another tool or other arguments is refused. Calls that only read pay no heed to it.
"""
