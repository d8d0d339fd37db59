"""What moves a joint beside its own motor: neighbours, a late stop, a swing from before."""
