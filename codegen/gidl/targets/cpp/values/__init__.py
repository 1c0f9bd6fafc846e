"""Views for the templates of `<file>_types.{hpp,cpp}`."""
