"""A report of a recorded run: what an engineer would put into one, from the bag alone."""
