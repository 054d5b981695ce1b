"""What a good closed loop is."""
