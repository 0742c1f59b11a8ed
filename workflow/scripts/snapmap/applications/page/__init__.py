"""The page to explore a study in a browser.  Imports: histories."""
