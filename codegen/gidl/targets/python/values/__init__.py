"""Views for the template of `<file>_types.py`."""
