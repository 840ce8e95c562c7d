"""The rungs of the ladder: models of one finger in one scene, from the cheapest to the finest.

Sizes follow the scene: the contact's forecast half-width, the plates, the finger's height;
``scale`` multiplies all of them. Single sizes were varied to find their proportions (maeno2000 with
five plates, 8 mm deep, against 300k equations; a homogeneous finger, 3.5 mm deep, against 150k):

- Finer plate ends serve the gages: ends of 0.12, 0.06, 0.03 mm on plates of 0.1 mm leave errors of
  2.9, 1.3, 1.3 %. Smaller far elements serve the forces: 2.5 and 1.5 mm leave 0.5 and 0.2 %.
- The stick ratio is the slowest: its border moves by parts of a facet. Facets of a tenth of the
  contact's half-width leave 5.5 % on 11k equations, of a twentieth 3.4 % on 14k, and with 1.4 times
  as many layers 1.6 % on 19k; F_n is within 0.3 % on all of them. So contact facets are small.
- Prisms need few layers: see ``mesh.section.extrude.layer_borders``.
- Sheets spare the small elements of plates' ends: coarse, they are cheaper and better than solids
  (10k equations and 6 % in the gages for 14k and 8 %); fine, they are not.
"""

import math

from fingerdesign.analysis.fidelity.models import Dimension, Model
from fingerdesign.analysis.path import steps_sideways
from fingerdesign.checks.load import with_values
from fingerdesign.checks.meshing import plane_strain_faults
from fingerdesign.design.mesh import SectionMesh
from fingerdesign.design.scene import Scene
from fingerdesign.design.schema import Design
from fingerdesign.errors import DesignError
from fingerdesign.layout.bodies import crest_height
from fingerdesign.layout.layers import sweepable
from fingerdesign.layout.rows import plate_frames
from fingerdesign.layout.zone import contact_reach, greatest_approach
from fingerdesign.mesh.make import mesher_name
from fingerdesign.mesh.section.section import sheet_room_faults

SPACE_SCALES = (4.0, 2.8, 2.0, 1.4, 1.0, 0.7)
SECTION_SCALES = (4.0, 2.0, 1.0, 0.5)
SHEETS_FROM = 4.0  # the first alone: the next, solid, judges it

_CONTACT, _PLATE, _END, _FAR = 0.05, 0.2, 0.6, 0.12  # see scene_sizes
_LAYERS, _LAYERS_DEPTH = 5.0, 4.0  # so many in half a depth of so many mm
_LEAST_HALF = 0.05  # of the body's half-width
_GRADATION = 0.5
_FARTHEST = 0.4  # of the crest's height


def scene_sizes(design: Design, scene: Scene, scale: float) -> SectionMesh:
    """Element sizes for what the scene will do to the finger.

    Contact facets: a twentieth of the contact's forecast half-width; along the plates 0.2 of the
    shortest one's length, at their ends 0.6 of its thickness; elsewhere 0.12 of the crest's height;
    all times ``scale``.
    """
    approach = greatest_approach(design, scene)
    wide, deep = contact_reach(design, scene.object, approach)
    most = 0.5 * design.body.width_mm
    half = max(min(wide, deep, most), _LEAST_HALF * most)  # a scene may hardly touch
    contact = _CONTACT * half
    far = _FAR * float(crest_height(design.body))
    frames = plate_frames(design) if design.plates.number else ()
    length = min((frame.length for frame in frames), default=far / _PLATE)
    thickness = min((frame.thickness for frame in frames), default=far / _END)
    return SectionMesh.model_construct(
        contact_size_mm=contact * scale,
        plate_size_mm=min(max(_PLATE * length, 1e-3) * scale, length),
        plate_end_size_mm=_END * thickness * scale,
        far_size_mm=min(far * scale, _FARTHEST * float(crest_height(design.body))),
        gradation=_GRADATION if scale >= 1.0 else _GRADATION * max(scale, 0.5),
    )


def layers(design: Design, scale: float) -> int:
    """Layers in half the depth: more of them the deeper, though not in proportion; 2 at least."""
    half = 0.5 * design.body.depth_mm
    layers = _LAYERS / scale * max(0.5, 1.0 + 0.5 * math.log2(half / _LAYERS_DEPTH))
    return max(2, math.ceil(layers))


def rung(design: Design, scene: Scene, dimension: Dimension, scale: float) -> Model:
    """The model of this dimension and scale; straight fingers are extruded."""
    sizes = scene_sizes(design, scene, scale)
    if dimension == "plane strain":
        return Model(dimension, sizes)
    extruded, solid = can_extrude(design), design.plates.number and design.plates.model == "solid"
    sheets = extruded and scale >= SHEETS_FROM and solid and can_be_sheets(design)
    mesher = "sweep" if extruded else mesher_name(design)
    return Model(dimension, sizes, layers(design, scale), "sheet" if sheets else None, mesher)


def can_extrude(design: Design) -> bool:
    """True if layers can mesh the finger, whatever mesher it asks for (a mesh's file excepted).

    Parts that end at nearly the same z want a layer too thin to mesh: those fTetWild takes.
    """
    return design.mesh.mesher != "file" and sweepable(design)


def can_be_sheets(design: Design) -> bool:
    """True if the plates have the room that sheets need in an extruded mesh."""
    if not design.extruded or any(row.follow == "bent" for row in design.plates.all_rows):
        return False
    try:
        return not sheet_room_faults(with_values(design, {"plates.model": "sheet"}))
    except DesignError:
        return False


def can_be_section(design: Design, scene: Scene) -> bool:
    """True if plane strain can show the finger and the scene at all."""
    if not design.body.straight or steps_sideways(scene):
        return False
    return not plane_strain_faults(design) and not sheet_room_faults(design)
