"""STEP files for tests: written, and read by the worker's code in this process."""

from fingerdesign.design import step as facts_module


def read_here(patch, folder=None):
    """No process is started to read STEP files; what is read is cached in ``folder`` of its own."""
    from fingerdesign.runtime.child import resolved

    patch.setattr(facts_module, "call", lambda name, *given, time_s: resolved(name)(*given))
    if folder is not None:
        patch.setenv("FINGERDESIGN_CACHE", str(folder))
        facts_module._outcome.cache_clear()


def write(work, path):
    from cadquery import exporters

    exporters.export(work, str(path), exporters.ExportTypes.STEP)
    return path
