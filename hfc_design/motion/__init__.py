"""What the machine is to do: references, loads, paths, G-code; how far it is off them."""
