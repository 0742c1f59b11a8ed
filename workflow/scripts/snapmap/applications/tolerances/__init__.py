"""Devices as made: values that scatter.  Imports: requirements."""
