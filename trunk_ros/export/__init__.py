"""Ways into other simulators: what their formats can say, and the reality layer for what they cannot."""
