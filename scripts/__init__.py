"""The `flexsim` command: verbs/ has one file a verb, the other folders what verbs share."""
