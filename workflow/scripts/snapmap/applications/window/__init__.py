"""Where on two axes required shocks are met.  Imports: requirements."""
