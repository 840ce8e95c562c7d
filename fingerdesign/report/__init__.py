"""A toolkit for pages: template, table, numbers, style; it knows no feature."""
