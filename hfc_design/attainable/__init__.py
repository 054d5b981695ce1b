"""Best attainable control: a certified lower bound of sum |e|, and a voltage close to it."""
