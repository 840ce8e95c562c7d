"""What is gripped, and with what: one finger or two, hardware, a recorded trace."""
