"""What `flexsim door fit` says: what logs can tell, what was fitted, what was held."""
