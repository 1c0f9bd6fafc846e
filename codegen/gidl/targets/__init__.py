"""Code generators, one package per language: `lower` prints types and codecs, `view` the files."""
