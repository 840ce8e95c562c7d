"""A small finger whose plates are soft, for measurements that are simulated."""

FINGER = """
[design]
name = "mine"
[body]
depth_mm = 8.0
[plates]
count = 4
length_mm = 0.9
pitch_mm = 1.2
cover_mm = 0.9
material = "polyimide"
[gages]
length_mm = 0.5
face = "upper"
[grip]
defaults = "fixed"
max_approach_mm = 0.25
[mesh.section]
contact_size_mm = 0.2
plate_size_mm = 0.3
"""
