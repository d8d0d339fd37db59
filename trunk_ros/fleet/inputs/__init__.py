"""Which recordings, of which arm, and of when."""
