"""Questions to a scene: what auto leaves open, statics, modes, linear models, offline runs, costs."""
