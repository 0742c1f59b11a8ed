"""A study as a data sheet.  Imports: requirements, statics."""
