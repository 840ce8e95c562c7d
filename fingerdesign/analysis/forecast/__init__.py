"""Cost of a model: equations, memory, seconds."""
