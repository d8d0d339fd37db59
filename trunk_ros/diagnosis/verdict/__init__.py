"""Findings and the result, in words and as data."""
