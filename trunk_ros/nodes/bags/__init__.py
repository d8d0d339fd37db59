"""What recorder and replay are made of."""
