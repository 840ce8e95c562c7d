"""The information that gages give about the stick ratio (validate --gages)."""
