"""What servo_driver and wire_elasticity are made of."""
