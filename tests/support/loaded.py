"""What the processes of tests have loaded when they start: see warm.py."""

import contextlib
from importlib import import_module

from fingerdesign.runtime.child import load_vtk_later

load_vtk_later()
for module in (
    "fingerdesign.mold.cad.write",
    "fingerdesign.mold.ready",
    "fingerdesign.mold.render",
    "fingerdesign.mesh.pictures",
    "fingerdesign.mesh.section.netgen",
    "fingerdesign.sensing.train.family",
    "fingerdesign.studio.judge",
    "fingerdesign.trials.tuning",
    "pytetwild",
):
    with contextlib.suppress(ImportError):  # a library that is not installed
        import_module(module)
