"""Products for the caster: drawings, patterns, 3MF, bill, casting notes."""
