"""Code generators, with one package for each language. In each package, the module `view` lists the
files to generate and their templates. The other modules build the views, from which the templates
print the files."""
