"""What flexsim was compared with, one file a comparison; `python benchmarks/validation_page.py` runs them."""
