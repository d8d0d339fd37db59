"""What happens between setpoint and gearbox shaft."""
