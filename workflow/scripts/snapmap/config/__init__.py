"""The door: files and text with units in, values in internal units out."""
