"""The command, and what jobs and a terminal show while a study runs."""
