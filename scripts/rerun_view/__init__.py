"""What rerun shows: one file a kind of thing shown."""
