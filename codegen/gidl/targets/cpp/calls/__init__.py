"""Views for the templates of `<file>_client`, `<file>_server`, `<file>_interface` and `<file>_calls`."""
