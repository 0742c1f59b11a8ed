"""Figures for print from cubes and histories; nothing else in the package imports matplotlib."""
