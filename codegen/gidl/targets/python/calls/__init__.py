"""Views for the template of `<file>.py`: client proxies and servants."""
