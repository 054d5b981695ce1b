"""The reference of all parts and keys, as gathered from the code. Never imports JAX."""
