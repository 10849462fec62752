"""The steps from each version of the tables to the next, carried out by alembic.

A new one is written by hand in ``versions``, and its number added to ``folding_server.store.schema.REVISIONS``.
"""
