"""Controllers compared and tuned: grid, bench, tuning, replay, page; the Gymnasium environment."""
