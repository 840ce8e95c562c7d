"""One finger in one scene: the case, refusals, stages, path, record."""
