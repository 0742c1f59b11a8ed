"""Force over displacement of a beam that is pushed slowly.  Imports: core alone."""
