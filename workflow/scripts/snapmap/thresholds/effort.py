"""How densely a search looks along N."""

SCAN_STEP, ISLAND_STEP, RAGGED_STEP = 0.03, 0.005, 0.001
"""Relative steps of N: in a first scan, in the scan for islands, and in ragged rows."""
PARTS = 4
"""Number of parts into which each round of a search cuts an interval; more parts cost more runs."""
TOGETHER, LANES = 8, 16
"""Most places of one row that are tried at once, and of all rows, if few, as fewer would take no
less time."""
CLOSE_STEP = 0.00025
"""Relative step of N close to a threshold."""
CLOSE_PLACES = 1, 2, 3, 4, 6, 8, 12, 16, 24, 32, 48, 64, 80
"""Distances from a threshold at which runs are compared, in CLOSE_STEP; the last is CLEAN_REACH."""
