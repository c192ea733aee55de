"""How a recorded run went: its topics' timing, its clock, what its simulators said of themselves."""
