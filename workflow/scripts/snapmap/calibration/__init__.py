"""A device read off its shots: level, duration and direction, tripped or not."""
