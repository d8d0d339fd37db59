"""The motion that tells rivals apart."""
