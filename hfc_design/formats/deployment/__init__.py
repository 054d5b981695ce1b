"""Files that are shipped with generated code: a README page, test vectors, and a test program."""
