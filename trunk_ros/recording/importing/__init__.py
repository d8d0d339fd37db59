"""Foreign recordings, by a mapping."""
