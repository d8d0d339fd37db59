"""Each recording diagnosed once, whatever happens to the run."""
