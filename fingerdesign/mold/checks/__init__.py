"""What is checked of a built mold."""
