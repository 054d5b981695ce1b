"""Many runs from one file: what to run, running it here or on workers, what came out."""
