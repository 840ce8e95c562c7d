"""One geometry of faces: planes, cylinders, spheres, tori, NURBS; scene objects."""
