"""What instruments on the links read, and what a user sees of a state."""
