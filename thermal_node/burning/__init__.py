"""The march through time, and the state in balance with the furnace."""
