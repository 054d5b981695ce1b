"""The search: strategies that propose and learn, and one loop that runs them."""
