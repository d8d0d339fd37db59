"""Every reader against inputs that are mutated towards code that no input has reached yet."""
