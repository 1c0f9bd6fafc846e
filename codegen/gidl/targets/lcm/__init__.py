"""Prints .lcm files for lcm-gen: types have the same encoding and fingerprint as in gidl's code."""
