"""What happens between gearbox shaft and joint, in physical order: path, friction, load, dynamics, sensor."""
