"""The reference: what there is, as it was gathered from the code. Never imports JAX."""
