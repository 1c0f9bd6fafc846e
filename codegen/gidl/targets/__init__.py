"""Code generators, with one package for each language. In a package, `view` lists the files and
their templates, and the other modules build the views."""
