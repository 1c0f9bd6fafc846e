"""The compiler of .gidl interface files. Start reading at model.py; the command line is cli.py."""

__version__ = "0.1.0"
