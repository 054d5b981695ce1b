"""``make reference``: rewrites the data file of the reference."""

from hfc_design.core.checkpoint import write_whole
from hfc_design.reference.entries import FILE, written
from hfc_design.schema.collect import collect

if __name__ == "__main__":
    write_whole(FILE, written(collect()).encode())
