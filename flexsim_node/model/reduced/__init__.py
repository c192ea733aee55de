"""Craig-Bampton reduction of a link: its modes, constants and where they lie."""
