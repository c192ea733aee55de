"""What `flexsim modes` draws."""
