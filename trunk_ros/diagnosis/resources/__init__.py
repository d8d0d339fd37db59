"""How much a diagnosis may simulate, keep and use of the machine."""
