"""Computes what packets contain from the model: encodings, function codes, hashes, fingerprints."""
