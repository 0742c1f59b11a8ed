"""Devices as made: values that scatter, and what that does to thresholds."""
