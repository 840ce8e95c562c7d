"""Tetrahedra and sections: meshers by name, quality, sheets, sizes."""
