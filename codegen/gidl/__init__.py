"""The compiler of .gidl interface files.

Start reading at model/. A file passes through files, syntax, resolve, rules, layout and targets,
in this order. The folder cli has the commands.
"""

__version__ = "0.1.0"
