"""Services of the machine: processes, caches, journals, whole files, registries."""
