"""What a value is, said once: units, kinds of values, records of them, and checked calls."""
