"""What is measured of the solver and of one device; a user runs these on theirs."""
