"""The compiler of .gidl interface files.

Start reading at model.py. A file passes through source, syntax, resolve, rules, layout, targets and
emit, in this order. The folder cli has the commands.
"""

__version__ = "0.1.0"
