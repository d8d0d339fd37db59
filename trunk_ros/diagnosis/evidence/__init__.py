"""What speaks for a finding, and what is left."""
