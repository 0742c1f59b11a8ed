"""Config files are read, checked, and converted to internal units."""
