"""A robot in motion: state, steps, runs, faults, loops that are assembled, validity."""
