"""Users' simulators: an arm as its user has it in MuJoCo, and what it really is."""
