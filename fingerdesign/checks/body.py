"""Faults of a body by itself: its arc, its dome, its edge, the core bonded into it."""

import numpy as np

from fingerdesign.checks.remedies import greatest
from fingerdesign.design.faults import at_least, at_most
from fingerdesign.design.schema import Body, Core
from fingerdesign.errors import Fault
from fingerdesign.layout import clearance
from fingerdesign.layout.clearance import LEAST_CLEARANCE_MM
from fingerdesign.layout.profile import profile_of

LEAST_EDGE_HEIGHT_MM = 0.1  # of the contact surface's border above the base
LEAST_EDGE_MM = 0.05  # of what an edge leaves of the top, and of the rounding itself


def body_faults(body: Body) -> list[Fault]:
    """Every fault of a body whose keys are sound; the first of arc, edge and dome only."""
    first = _arc_faults(body) or _edge_faults(body) or _dome_faults(body)
    return first or _core_faults(body)


def _arc_faults(body: Body) -> list[Fault]:
    arc = body.kind.closed_form and not body.kind.flat
    if not arc or body.arc_radius_mm >= 0.5 * body.width_mm - 1e-9:
        return []
    bound = f"at least body.width_mm / 2 = {0.5 * body.width_mm:g}"
    remedy = f"raise it, or lower body.width_mm to at most {at_most(2 * body.arc_radius_mm)}"
    return [Fault("body.arc_radius_mm", body.arc_radius_mm, bound, remedy)]


def sound_outline(body: Body) -> bool:
    """Tell whether a parametric body's section has an outline at all."""
    return body.shape == "step" or not (
        (not body.kind.flat and body.arc_radius_mm < 0.5 * body.width_mm) or _edge_faults(body)
    )


def _edge_faults(body: Body) -> list[Fault]:
    """A rounding or chamfer that leaves nothing of the top or of the side, or rounds no corner."""
    edge, half = body.edge_radius_mm, 0.5 * body.width_mm
    if edge is None:
        return []
    key, flat = "body.edge_radius_mm", body.kind.flat
    if edge > half - LEAST_EDGE_MM + 1e-9:
        most = half - LEAST_EDGE_MM
        if flat or body.edge == "chamfer":  # it comes down the side as far as over the top
            most = max(min(most, body.base_height_mm - LEAST_EDGE_HEIGHT_MM), 0.0)
        bound = f"at most {most:g}, so that something of the top is left"
        return [Fault(key, edge, bound, f"lower it to at most {at_most(most)}")]
    if not flat and body.edge == "round":
        sine = (half - edge) / (body.arc_radius_mm - edge)
        left = edge * float(0.5 * np.pi - np.arcsin(min(sine, 1.0)))
        if left < LEAST_EDGE_MM - 1e-9:
            bound = "absent where the arc meets the sides without a corner"
            return [Fault(key, edge, bound, "remove it or raise body.arc_radius_mm")]
    height = profile_of(body).side_height
    if height < LEAST_EDGE_HEIGHT_MM - 1e-9:
        bound = f"such that {LEAST_EDGE_HEIGHT_MM} mm of the sides are left (now {height:.4g})"
        raised = at_least(body.base_height_mm + LEAST_EDGE_HEIGHT_MM - height)
        return [Fault(key, edge, bound, f"lower it or raise body.base_height_mm to {raised}")]
    return []


def _dome_faults(body: Body) -> list[Fault]:
    if body.dome_radius_mm is None or not sound_outline(body):
        return []
    least = clearance.least_dome_radius(body, LEAST_EDGE_HEIGHT_MM)
    if body.dome_radius_mm >= least - 1e-9:
        return []
    bound = f"such that the dome's corners stay {LEAST_EDGE_HEIGHT_MM} mm above the base"
    remedy = f"raise it to at least {at_least(least)} or lower body.depth_mm"
    return [Fault("body.dome_radius_mm", body.dome_radius_mm, bound, remedy)]


def _core_faults(body: Body) -> list[Fault]:
    """A core that leaves the body, or leaves a skin of rubber too thin to cast."""
    core = body.core
    if core is None or not sound_outline(body):
        return []
    stages = (_skin_faults, _whole_section, _round_core, _core_top, _core_in_step)
    return next(filter(None, (find(body, core) for find in stages)), [])


def _skin_faults(body: Body, core: Core) -> list[Fault]:
    """A core that leaves a skin of rubber too thin to cast next to it, or below it."""
    faults, why = [], f"a skin below {LEAST_CLEARANCE_MM} mm cannot be cast"
    for name in ("width_mm", "depth_mm"):
        extent, outer = getattr(core, name), getattr(body, name)
        inner = outer - 2.0 * LEAST_CLEARANCE_MM
        if extent is not None and extent > inner + 1e-9 and extent != outer:
            bound = f"body.{name} = {outer:g} or at most {inner:g}"
            remedy = f"{why}; lower it to {at_most(inner)}"
            faults.append(Fault(f"body.core.{name}", extent, bound, remedy))
    if 0.0 < core.bottom_mm < LEAST_CLEARANCE_MM - 1e-9:
        bound = f"0 (it is on the base) or at least {LEAST_CLEARANCE_MM}"
        faults.append(Fault("body.core.bottom_mm", core.bottom_mm, bound, why))
    return faults


def _whole_section(body: Body, core: Core) -> list[Fault]:
    """A core off the base that fills the body's whole section: it cuts the rubber in two."""
    full = core.width_mm == body.width_mm and core.depth_mm in (None, body.depth_mm)
    if not full or core.bottom_mm == 0.0:
        return []
    bound = "0 for a core of the body's full width and depth: it would cut the rubber in two"
    remedy = "set it to 0, or narrow the core by body.core.width_mm or body.core.depth_mm"
    return [Fault("body.core.bottom_mm", core.bottom_mm, bound, remedy)]


def _core_in_step(body: Body, core: Core) -> list[Fault]:
    """A core that leaves a STEP body's sides or ends, meets its voids, or lies too near to them."""
    if body.shape != "step":
        return []

    def clear(changed: dict[str, float]) -> float:
        trial = core.model_copy(update=changed)
        return clearance.core_clearance(body.model_copy(update={"core": trial}))

    found = clear({})
    if found >= LEAST_CLEARANCE_MM - 1e-9:
        return []
    bound = f"such that the core lies {LEAST_CLEARANCE_MM} mm inside the STEP body's sides and ends"
    reported = f"{bound}, clear of its voids (now {found:.4g} mm)"
    for name in ("width_mm", "depth_mm", "height_mm"):
        value = getattr(core, name)
        now = body.depth_mm if value is None else value

        def holds(trial: float, name: str = name) -> bool:
            return clear({name: trial}) >= LEAST_CLEARANCE_MM

        most = greatest(holds, 0.5, now)
        if most is not None:
            given = "(absent: the full depth)" if value is None else value
            word = "set it to" if value is None else "lower it to at most"
            return [Fault(f"body.core.{name}", given, reported, f"{word} {at_most(most)}")]
    remedy = "narrow and lower the core, or move it by body.core.bottom_mm"
    return [Fault("body.core.width_mm", core.width_mm, reported, remedy)]


def _round_core(body: Body, core: Core) -> list[Fault]:
    """A core in a revolved body: its corners stay inside the round section."""
    if not body.kind.turned:
        return []
    depth = body.core_depth_mm
    allowed = 0.5 * body.width_mm - LEAST_CLEARANCE_MM
    reach = float(np.hypot(0.5 * core.width_mm, 0.5 * depth))
    if reach <= allowed + 1e-9:
        return []
    bound = f"such that the core's corners stay {LEAST_CLEARANCE_MM} mm inside the round section"
    reported = f"{bound} of radius {0.5 * body.width_mm:g} (they reach {reach:.4g})"
    key, other, given = "body.core.depth_mm", core.width_mm, core.depth_mm is not None
    if given:
        key, other = "body.core.width_mm", depth
    room = float(allowed**2 - 0.25 * other**2)
    if room > 0.01:
        most = at_most(2.0 * room**0.5)
        remedy = f"lower it to at most {most}" if given else f"set it to {most}"
    elif given:
        remedy = "lower it and body.core.depth_mm"
    else:
        remedy = f"set it, and body.core.width_mm, to at most {at_most(allowed * 2.0**0.5)}"
    value = core.width_mm if given else "(absent: the full depth)"
    return [Fault(key, value, reported, remedy)]


def _core_top(body: Body, core: Core) -> list[Fault]:
    """A core whose upper corners come too near to the contact surface."""
    depth = body.core_depth_mm

    def cover(height: float) -> float:
        x, z = (np.linspace(-0.5, 0.5, 9) * extent for extent in (core.width_mm, depth))
        top = np.array([[a, core.bottom_mm + height, b] for a in x for b in z])
        clear = clearance.surface_clearances(body, top)
        return -np.inf if np.isnan(clear).any() else float(clear.min())

    if cover(core.height_mm) >= LEAST_CLEARANCE_MM - 1e-9:
        return []
    most = greatest(lambda h: cover(h) >= LEAST_CLEARANCE_MM, 0.1, core.height_mm)
    remedy = "lower body.core.bottom_mm or narrow the core"
    if most is not None:
        remedy = f"lower it to at most {at_most(most)} or {remedy}"
    bound = f"such that the core lies {LEAST_CLEARANCE_MM} mm below the contact surface"
    return [Fault("body.core.height_mm", core.height_mm, bound, remedy)]
