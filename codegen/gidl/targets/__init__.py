"""One package per language: `lower` decides how a type and its codec look, `view` prepares files."""
