"""What code is shipped with: a page on the design, test vectors, and a check that runs them."""
