"""Signals as tables: read from the files of other tools, and written for them."""
