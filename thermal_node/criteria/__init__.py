"""How a door is judged: criteria, standards, the furnace's tolerance, the verdict."""
