"""MCAP files, read, written and repaired."""
