"""What the compensator is made of."""
