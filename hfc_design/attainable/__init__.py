"""How good any controller could be: a certified lower bound of sum |e|, and a voltage near it."""
