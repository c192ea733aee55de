"""The verbs of the `flexsim` command, one a file; none imports another."""
