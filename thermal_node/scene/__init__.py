"""What a user writes: scene files read and checked; the standards that they name."""
