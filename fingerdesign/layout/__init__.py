"""Places in numbers alone: plates, outline, surface, candidate zone, volumes, gaps."""
