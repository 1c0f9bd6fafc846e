"""What the template of `<file>_types.py` prints."""
