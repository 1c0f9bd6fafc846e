"""The compiler of .gidl interface files.

Start reading at model/. An interface file passes through files, syntax, resolve, rules, wire and
targets, in this order. The folder cli has the commands.
"""

__version__ = "0.1.0"
