"""Version 0002: events may have the id of the request that they were recorded for."""

import sqlalchemy as sa
from alembic import op

revision = "0002"
down_revision = "0001"


def upgrade() -> None:
    """Add the column, empty, and an index by which a request is carried out once."""
    columns = {column["name"] for column in sa.inspect(op.get_bind()).get_columns("folding_events")}
    if "request_id" not in columns:
        op.add_column("folding_events", sa.Column("request_id", sa.String(36), nullable=True))
    op.create_index("folding_events_requests", "folding_events", ["request_id"], unique=True)
