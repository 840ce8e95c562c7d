"""One geometry of faces: planes, cylinders, spheres, NURBS; scene objects."""
