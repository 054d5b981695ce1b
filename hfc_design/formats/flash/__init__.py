"""What code is flashed with beside itself: a page on the design, test vectors, and a check."""
