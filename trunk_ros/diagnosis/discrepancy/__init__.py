"""Physics without a name, as curves."""
