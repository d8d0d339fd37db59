"""The search, piece by piece."""
