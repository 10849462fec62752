"""What alembic runs: all steps that are missing, on the connection and in the transaction that the store holds."""

from alembic import context

from folding_server.store.schema import STORED_VERSION

context.configure(connection=context.config.attributes["connection"], version_table=STORED_VERSION.name)
with context.begin_transaction():
    context.run_migrations()
