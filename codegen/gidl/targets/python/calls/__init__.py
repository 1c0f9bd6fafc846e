"""Builds the views of client proxies and servants, for the template of `<file>.py`."""
