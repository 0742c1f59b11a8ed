"""Files that are whole or absent, and what is written in them beside data."""
