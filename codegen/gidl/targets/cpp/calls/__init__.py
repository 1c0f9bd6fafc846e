"""Views for the templates of `<file>_client.{hpp,cpp}` and `<file>_server.{hpp,cpp}`."""
