"""Plants: one finger or two, an object on its support, imperfect hardware."""
