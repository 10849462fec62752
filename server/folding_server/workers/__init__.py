"""Long work beside the server: worker processes, a fair and bounded queue before them, and stopping what nobody waits for."""
