"""What is diagnosed: setpoint to gearbox, gearbox to joint; the tip has a room of its own."""
