"""Reference of all parts (plants, controllers, ...) and all keys of files. Never imports JAX."""
