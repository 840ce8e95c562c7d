"""What the caster gets: drawings, patterns, 3MF, bill, casting notes."""
