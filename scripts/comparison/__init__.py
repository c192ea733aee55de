"""Two runs side by side: where they differ, by how much, and since when."""
