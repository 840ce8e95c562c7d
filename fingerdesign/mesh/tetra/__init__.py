"""pytetwild: sizes, slots for plates, snapping to the CAD surface, acceptance."""
