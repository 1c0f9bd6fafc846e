"""The compiler of .gidl interface files.

Start reading at model.py. The way of a file is source, syntax, resolve, rules, layout, targets, and
emit; cli has the commands.
"""

__version__ = "0.1.0"
