"""What bringup is made of."""
