"""What the kinds whose parameters are a few gains have in common."""
