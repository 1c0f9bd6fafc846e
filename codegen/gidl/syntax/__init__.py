"""Turns the text of one file into its syntax tree: lexer, preprocessor and parser."""
