"""What the templates of `<file>_types.{hpp,cpp}` print."""
