"""CadQuery: solids, plates, faces, tessellation, export, STEP bodies."""
