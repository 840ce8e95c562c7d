"""Settings of the documentation site (docs/reference/site.md); `make site` reads them."""

import os
import sys
from pathlib import Path

HERE = Path(__file__).parent
sys.path[:0] = [str(HERE), str(HERE.parent), str(HERE.parent / "cli")]

# pyvista draws without a display, and hands its scenes to the gallery.
os.environ |= {"PYVISTA_OFF_SCREEN": "true", "PYVISTA_BUILDING_GALLERY": "true"}

from fingerdesign import __version__  # noqa: E402

project, author = "fingerdesign", "the fingerdesign developers"
version = release = __version__
html_title = f"fingerdesign {release}"
html_theme = "furo"
html_static_path = ["site_static"]
html_css_files = ["site.css"]
html_show_copyright = False
html_show_sourcelink = False

extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx_gallery.gen_gallery", "site_hooks"]
exclude_patterns = ["gallery/*", "images/*", "generated/*", "paper/*"]
suppress_warnings = ["config.cache"]

# A link that leads nowhere is a warning, and `make site` takes warnings for errors. Names of other
# packages in signatures are no links: the build needs no network.
nitpicky = True
nitpick_ignore_regex = [
    (r"py:.*", r"(?!fingerdesign\.).*"),
    (r"py:.*", r"fingerdesign\.arrays\..*"),  # names for numpy's arrays
    (r"py:.*", r"fingerdesign\..*\._?[a-z]\w*"),  # rules of validation in signatures
    (r"py:.*", r"fingerdesign\..*\._\w+"),
]
# Inner types that signatures of the API name, and that have no page.
INNER = """
contact.memory.Rubber contact.solver.newton.ActiveInverse contact.solver.tracking.Tracker
control.estimator.Band control.estimator.Estimated control.estimator.FingerCurves
control.estimator.Moment control.plants.slide.Inertia
design.body.BodyKind design.body.Core design.body.StepFile
"""
nitpick_ignore = [("py:class", f"fingerdesign.{name}") for name in INNER.split()]

myst_enable_extensions = ["colon_fence", "deflist"]
myst_heading_anchors = 3

autodoc_member_order = "bysource"
autodoc_typehints_format = "short"

sphinx_gallery_conf = {
    "examples_dirs": "gallery",
    "within_subsection_order": "FileNameSortKey",
    "backreferences_dir": None,
    "gallery_dirs": "examples",
    "filename_pattern": r"/\d\d_",
    "ignore_pattern": r"__init__",
    "image_scrapers": (
        "site_hooks.drawings",
        "matplotlib",
        "site_hooks.scenes",
        "site_hooks.turnable",
    ),
    "reset_modules": ("site_hooks.fresh_look",),
    "reset_modules_order": "both",
    "capture_repr": (),
    "thumbnail_size": (480, 336),
    "download_all_examples": False,
    "write_computation_times": False,
    "min_reported_time": 0,
    "remove_config_comments": True,
    "abort_on_example_error": True,
}
