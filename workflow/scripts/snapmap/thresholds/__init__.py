"""Where snapping begins, with its error and islands."""
