"""Code generators, with one package for each language. In a package, `lower` prints types and
codecs, and `view` lists the files."""
