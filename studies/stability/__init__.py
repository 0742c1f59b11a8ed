"""Hard cases: which runs are sound, which are caught, and whether any goes wrong unseen."""
