"""A mold's report.html: verdict, picture, casting notes to tick, tables; offline and printable."""

from __future__ import annotations

from typing import Any

from markupsafe import Markup

from fingerdesign.mold.caster_warnings import (
    DOUBTFUL_SHARE,
    placement_remedy,
    placement_worst,
)
from fingerdesign.report.html import rendered
from fingerdesign.report.mold_base_plan import base_svg, holes_table
from fingerdesign.report.mold_checks_tables import checks_table, kinds_table
from fingerdesign.report.mold_picture import Exploded
from fingerdesign.report.mold_tables import (
    as_words,
    bill_table,
    effects_table,
    fixture_table,
    hardware_text,
    limits_table,
    parts_table,
    patterns_table,
    plates_table,
)

PROCESSES = {"sla": "resin prints", "fdm": "filament prints", "machined": "machined parts"}


def mold_html(data: dict[str, Any], picture: Exploded | None, missing: str = "") -> str:
    """The page, from what mold_report.json holds; ``missing`` says why there is no picture."""
    failing = [check for check in data["checks"] if not check["ok"]]
    return rendered(
        "mold.html.j2",
        data=data,
        words=as_words,
        verdict=_verdict(data, failing),
        failing=failing,
        picture=picture,
        missing=missing,
        process=PROCESSES[data["process"]["name"]],
        parts=parts_table(data),
        holes=holes_table(data["base"]),
        base_plan=Markup(base_svg(data["base"])),
        hardware=hardware_text(data),
        kinds=kinds_table(data["checks"]),
        failed=checks_table(failing, "failed", "Failed"),
        passed=checks_table([c for c in data["checks"] if c["ok"]], "passed", "Passed"),
        plates=plates_table(data),
        patterns=patterns_table(data),
        fixture=fixture_table(data),
        effects=effects_table(data["placement"]),
        bill=bill_table(data),
        limits=limits_table(data),
    )


def _verdict(data: dict[str, Any], failing: list[dict[str, Any]]) -> dict[str, str]:
    count = len(data["checks"])
    worst = placement_worst(data["placement"])
    if data["failure"] is None and worst > DOUBTFUL_SHARE:
        remedy = placement_remedy(side["holding"] for side in data["fixture"])
        return {
            "kind": "partly",
            "answer": "can be cast, gages in doubt",
            "text": f"All {count} checks passed. But plates off their places by what holds them "
            f"change a reading by up to {100 * worst:.0f} % of the largest: to know what gages "
            f"read before you cast, {remedy}; else calibrate each finger.",
        }
    if data["failure"] is None:
        return {
            "kind": "yes",
            "answer": "ready to cast",
            "text": f"All {count} checks passed. {len(data['parts'])} parts.",
        }
    if not data["parts"]:
        return {"kind": "no", "answer": "not made", "text": data["failure"]}
    return {
        "kind": "no",
        "answer": "not ready",
        "text": f"{len(failing)} of {count} checks failed: see below before anything is printed.",
    }
