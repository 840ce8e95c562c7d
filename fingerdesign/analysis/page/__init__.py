"""report.html of one analysis: verdict, figures, tables, pictures."""
