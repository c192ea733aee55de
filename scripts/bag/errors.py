"""What can be wrong with a bag."""


class BagError(ValueError):
    """A bag that is missing, in the way, or without what was asked of it."""


class BagDamaged(UserWarning):
    """A part of a bag can't be read; the rest is."""
