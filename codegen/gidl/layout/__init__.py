"""Computes numbers and names from the model: wire encodings, codes, hashes, and names in the
output."""
