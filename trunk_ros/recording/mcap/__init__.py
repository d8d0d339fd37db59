"""MCAP files, read, written and repaired."""

COMPRESSION = ("zstd", "lz4", "none")
"""How chunks can be written."""
