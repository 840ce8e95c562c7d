"""Where things lie, numbers alone: plates, outline, surface, candidate zone, volumes, gaps."""
