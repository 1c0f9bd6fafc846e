"""Builds the model from syntax trees: looks up names, computes constants and reads annotations."""
