"""From text to the syntax tree of one file: lexer, preprocessor and parser."""
