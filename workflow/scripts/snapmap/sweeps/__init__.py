"""A study's cells: cut into slabs, followed, joined into one cube."""
