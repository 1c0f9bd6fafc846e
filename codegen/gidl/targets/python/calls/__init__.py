"""What the template of `<file>.py` prints: client proxies and servants."""
