"""Control laws, most of a feed drive, written once for the simulator and the runtime; no JAX."""
