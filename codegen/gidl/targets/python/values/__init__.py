"""Builds the views for the template of `<file>_types.py`."""
