"""Errors and warnings, the places in source texts to which they point, and their output."""
