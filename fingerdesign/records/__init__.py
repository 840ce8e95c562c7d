"""Records: one typed definition for JSON, schema and CSV; results, outcomes."""
