"""What a model will take: equations, memory, seconds."""
