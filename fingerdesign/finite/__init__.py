"""The finger at finite strain, pressed and sheared by a rigid object."""
