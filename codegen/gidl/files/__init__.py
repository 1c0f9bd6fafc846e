"""Finds, reads and names files: interface files, and the files that are generated from them."""
