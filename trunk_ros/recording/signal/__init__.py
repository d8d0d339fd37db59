"""Signals between their samples: encoders, gaps, interpolation."""
