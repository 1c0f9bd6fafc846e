"""Chooses the names that declarations have in generated code: words that a language reserves, names
of types, and names that two files would both define."""
