"""A design that is analysed in seconds, for tests of what is done with it."""

import tomlkit


def write_coarser(path):
    """The design of a file with three plates, a coarse swept mesh and one friction coefficient."""
    design = tomlkit.parse(path.read_text("utf-8"))
    design["grip"]["friction_coefficients"] = [0.5]
    sizes = {"contact_size_mm": 0.2, "plate_size_mm": 0.2, "plate_end_size_mm": 0.1}
    design["plates"]["count"] = 3
    space = {"mesher": "sweep", "layers": 2, "contact_size_mm": 1.2, "plate_size_mm": 1.2}
    design["mesh"] |= space | {"section": sizes}
    path.write_text(tomlkit.dumps(design), "utf-8")
