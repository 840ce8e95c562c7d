"""What work needs of the machine: processes, kept work, journals, whole files, registries."""
