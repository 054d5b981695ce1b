"""Schema of files and parts: keys, units and meanings, collected from fields and comments."""
