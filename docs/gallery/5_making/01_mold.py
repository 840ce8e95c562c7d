"""
The mold, exploded
==================

Contact insert, two half frames, a comb in the end of each, and the base plate, which is pressed
on last. ``fingerdesign mold`` writes all parts as STL and STEP, and one 3MF for the printer.
The picture moves each part along its draw.
"""

import tempfile
from pathlib import Path

import pyvista

from fingerdesign.checks.load import load_design
from fingerdesign.mold.make import write_mold

MOVES = {
    "contact_insert": (0, 14, 0),
    "frame_front": (0, 0, 26),
    "frame_back": (0, 0, -26),
    "comb_front": (0, 0, 12),
    "comb_back": (0, 0, -12),
    "base_plate": (0, -14, 0),
}
COLOURS = {"comb": "#0a8f6b", "base": "#8d939a"}

plotter = pyvista.Plotter(window_size=(1200, 900))
with tempfile.TemporaryDirectory() as folder:
    record = write_mold(load_design("maeno2000"), Path(folder) / "mold")
    for name, move in MOVES.items():
        part = pyvista.read(Path(folder) / "mold" / f"{name}.stl").translate(move)
        colour = COLOURS.get(name.partition("_")[0], "#b9d3e6")
        plotter.add_mesh(part, color=colour, ambient=0.3)
        edges = part.extract_feature_edges(30, boundary_edges=False, manifold_edges=False)
        plotter.add_mesh(edges, color="#3d4d59", line_width=1.0)
plotter.camera_position = [(-60.0, 55.0, 95.0), (0.0, 3.0, 0.0), (0.0, 1.0, 0.0)]
plotter.camera.zoom(0.8)
plotter.enable_anti_aliasing("ssaa")
plotter.show()

print(record["status"], "-", len(record["checks"]), "checks")
