"""The cross-section: outline, plates, netgen, and its extrusion."""
