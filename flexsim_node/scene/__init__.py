"""What a user writes: scene files read and checked, their torques, scenes made of a scene."""
