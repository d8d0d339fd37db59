"""Real recordings: the project beside what others would use, each fitted to the same rows."""
