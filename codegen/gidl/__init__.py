"""The compiler of .gidl interface files. Start reading at model.py; the command line is cli.py."""
