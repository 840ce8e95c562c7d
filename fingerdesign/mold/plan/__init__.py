"""The mold in numbers: walls, legs, slots, fixtures, fasteners, base plate."""
