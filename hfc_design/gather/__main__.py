"""``make reference``: rewrites the data file of the reference."""

from hfc_design.core.checkpoint import write_whole
from hfc_design.gather.gather import gather
from hfc_design.reference.entries import FILE, written

if __name__ == "__main__":
    write_whole(FILE, written(gather()).encode())
