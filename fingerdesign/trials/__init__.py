"""Controllers compared and tuned: grid, bench, tuning, replay, page."""
