"""Small fingers, meshed coarsely: in 3-D by sweeping, and in plane strain with a hand."""

SMALL = """
design.name = "small"
body.width_mm = 12.0
body.base_height_mm = 5.0
body.depth_mm = 6.0
plates.count = 2
plates.pitch_mm = 3.0
plates.thickness_mm = 0.3
mesh.mesher = "sweep"
mesh.layers = 2
mesh.contact_size_mm = 1.2
mesh.plate_size_mm = 1.0
"""
COARSE = """
[design]
name = "coarse"
[plates]
count = 5
length_mm = 1.0
cover_mm = 1.2
[gages]
length_mm = 0.6
[mesh.section]
contact_size_mm = 0.3
plate_size_mm = 0.4
plate_end_size_mm = 0.1
[grip]
defaults = "fixed"
"""
CORE = {"body.core.width_mm": 6.0, "body.core.height_mm": 1.5, "body.core.bottom_mm": 1.0}
