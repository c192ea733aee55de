"""The `flexsim` command: one file a verb, and the folders its verbs share."""
