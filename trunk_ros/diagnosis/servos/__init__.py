"""What recordings say of the nominal servos before anything is searched."""
