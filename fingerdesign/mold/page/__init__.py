"""The mold report: page, tables, exploded picture."""
