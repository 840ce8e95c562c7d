"""STEP files for tests: written, and read by the worker's code in this process."""

from fingerdesign.design import step as facts_module


def read_here(patch, folder):
    """What is read of STEP files is kept in ``folder``; no process is started for it."""
    from fingerdesign.runtime.child import resolved

    patch.setenv("FINGERDESIGN_CACHE", str(folder))
    patch.setattr(facts_module, "call", lambda name, *given, time_s: resolved(name)(*given))
    facts_module._outcome.cache_clear()


def write(work, path):
    from cadquery import exporters

    exporters.export(work, str(path), exporters.ExportTypes.STEP)
    return path
