"""Mesh files: what meshio reads and writes, CalculiX decks, meshes made elsewhere."""
