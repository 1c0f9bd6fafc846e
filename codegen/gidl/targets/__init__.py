"""One package per language: `lower` decides how types and codecs look, `view` prepares files."""
