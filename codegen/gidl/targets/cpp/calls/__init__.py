"""Views for the templates of `<file>_client`, `_server`, `_interface` and `_calls`."""
