"""Prints .lcm files for lcm-gen. Their types have the same encodings and fingerprints as the code
that gidl generates."""
