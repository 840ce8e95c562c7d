"""Search for a finger that passes all of its verdicts, from one design."""
