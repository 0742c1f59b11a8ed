"""Files that are whole or absent, tables, and text that is safe in messages and tables."""
