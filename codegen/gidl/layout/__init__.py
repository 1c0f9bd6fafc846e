"""From the model to numbers and names: wire encodings, codes, hashes, and names in the output."""
