"""The search: genomes, two strategies that ask and are told, one loop that drives them."""
