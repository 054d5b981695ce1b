"""Functions of the Python API; the command line calls the same ones where it does the same."""
