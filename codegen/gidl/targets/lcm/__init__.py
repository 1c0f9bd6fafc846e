"""The .lcm files that lcm-gen reads: the same bytes and fingerprints for every type."""
