"""What scripts call, and where the command line does the same, the command line too."""
