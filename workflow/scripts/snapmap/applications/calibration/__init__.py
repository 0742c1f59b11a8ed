"""Values of a device estimated from measured shots.  Imports: core alone."""
