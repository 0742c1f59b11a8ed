"""The applications, each a folder with all that is its own."""
