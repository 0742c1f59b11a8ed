"""Studies that measure the solver; users can run them on their own devices."""
