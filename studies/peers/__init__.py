"""snapmap beside what a user could take instead, in one run: `./run python -m studies peers`."""
