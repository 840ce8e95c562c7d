"""Many fingers: studies, runs, searches, comparison."""
