"""What can be wrong with a bag."""


class BagError(ValueError):
    """A bag that is missing, damaged, in the way, or without what was asked of it."""
