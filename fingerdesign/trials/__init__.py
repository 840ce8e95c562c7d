"""Controllers compared and tuned: grid, bench, tuning, page; the Gymnasium environment."""
