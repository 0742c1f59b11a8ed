"""The command, and what jobs and terminal say while a study is made."""
