"""The studio: a local page on which a finger's numbers follow its sliders."""
