"""May it be: the keys first, then the geometry; reading and writing of design files."""
