"""Version 0001: the table of events. Databases without it are made anew, so nobody gets here."""

revision = "0001"
down_revision = None


def upgrade() -> None:
    """Nothing comes before."""
