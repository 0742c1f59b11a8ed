"""Hard cases: runs that are sound, runs whose errors are caught, and runs that are wrong unseen."""
