"""What all commands and nodes ask for and say on the command line."""
