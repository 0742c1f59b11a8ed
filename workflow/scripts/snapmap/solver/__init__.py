"""Cells in, observations out: two time loops, and a model that chooses among several."""
