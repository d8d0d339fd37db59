"""What happens between joints and tip."""
