"""What the furnace does: curves, logs, burners, and which readings are believed."""
