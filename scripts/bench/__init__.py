"""A controller on the bench: a robot in lockstep, moves, disturbances and faults, and scores of each."""
