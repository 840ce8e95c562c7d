"""Who decides the next move; each registered by its name."""
