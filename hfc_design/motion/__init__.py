"""Motion of a machine: references, loads, paths, G-code, and the deviation from them."""
