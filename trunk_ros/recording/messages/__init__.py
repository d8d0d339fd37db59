"""Messages as bytes and as columns."""
