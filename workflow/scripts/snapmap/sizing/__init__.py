"""Which values a device should have."""
