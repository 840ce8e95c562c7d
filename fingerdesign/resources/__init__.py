"""What a model will cost on this machine, told before it is built: elements, memory, seconds."""
