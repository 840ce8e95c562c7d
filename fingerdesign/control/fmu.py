"""The regulator in C as a functional mock-up unit: FMI 2.0, co-simulation, sources inside.

    (folder / "regulator.fmu").write_bytes(fmu(estimator, design.grip))

A zip of a description, the sources (fmu.c, regulator.c, regulator.h), the weights in resources/,
and on Linux with a compiler the library, for x86-64 or AArch64. Weights do not compress: library
and sources share the one file. One step of the unit is one sample of the hand. The finger's curves
are constants; the delay, the stiffness and the cross-talk are parameters.
"""

from __future__ import annotations

import hashlib
import io
import platform
import sys
import tempfile
import zipfile
from pathlib import Path
from typing import TYPE_CHECKING
from xml.etree import ElementTree as xml

import numpy as np

from fingerdesign.control.c_code import array_text, c_files, filled_template, weights_of
from fingerdesign.control.estimator import GripEstimator
from fingerdesign.runtime.native import made_library

if TYPE_CHECKING:
    from fingerdesign.design.grip import Grip

MODEL = "regulator"
FILE, WEIGHTS = f"{MODEL}.fmu", "weights.bin"
_PLATFORMS = {"x86_64": "linux64", "aarch64": "aarch64-linux"}
_OUTPUTS = {
    "dx": ("mm", "next move of the hand, away from the support"),
    "dy": ("mm", "next move of each finger, closing"),
    "stick_ratio": ("", "stick area over contact area"),
    "used": ("", "F_t over friction times F_n"),
    "friction": ("", "coefficient of friction; 0 before anything is known"),
}
_PARAMETERS = {
    "stiffness": ("N/mm", "dF_t/dx at the preload"),
    "cross_talk": ("", "measured as F_t of each newton of F_n"),
}
_EPOCH = (1980, 1, 1, 0, 0, 0)  # The same unit is the same bytes.


def fmu(estimator: GripEstimator, grip: Grip) -> bytes:
    """The unit of an estimator and a design's ``[grip]`` table."""
    curves = estimator.curves
    stiffness = float(np.interp(grip.preload_mm, curves.approach, curves.stiffness))
    tables = {"FORCE": curves.normal_force, "PRESSED": curves.pressed.ravel()}
    tables |= {"STICKING": curves.sticking.ravel(), "APPROACH": curves.approach}
    tables |= {"STIFFNESS": curves.stiffness}
    places = {
        "@period@": repr(1.0 / grip.hardware.sample_rate_Hz),
        "@points@": str(len(curves.normal_force)),
        "@stiffness@": repr(stiffness),
        "@curves@": "\n".join(array_text(f"CURVE_{k}[]", v) for k, v in tables.items()),
    }
    # High bytes, then low ones: together they compress worse.
    weights = weights_of(estimator).astype(">i2").view(np.uint8).reshape(-1, 2).T.tobytes()
    sources = c_files(estimator, grip, with_weights=False)
    sources |= {"fmu.c": filled_template("fmu.c", places)}
    digest = hashlib.sha256("".join(sources.values()).encode() + weights).hexdigest()
    guid = (
        f"{{{'-'.join((digest[:8], digest[8:12], digest[12:16], digest[16:20], digest[20:32]))}}}"
    )
    sources["fmu.c"] = sources["fmu.c"].replace("@guid@", guid)
    content = {f"sources/{name}": text.encode() for name, text in sources.items()}
    content[f"resources/{WEIGHTS}"] = weights
    described = description(estimator, guid, 1.0 / grip.hardware.sample_rate_Hz, stiffness)
    content["modelDescription.xml"] = described.encode()
    system = _PLATFORMS.get(platform.machine()) if sys.platform == "linux" else None
    if system is not None and (library := _compiled(sources)) is not None:
        content[f"binaries/{system}/{MODEL}.so"] = library
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w", zipfile.ZIP_DEFLATED) as archive:
        for name in sorted(content):
            about = zipfile.ZipInfo(name, _EPOCH)
            archive.writestr(about, content[name], zipfile.ZIP_DEFLATED, compresslevel=9)
    return stream.getvalue()


def _compiled(sources: dict[str, str]) -> bytes | None:
    with tempfile.TemporaryDirectory() as folder:
        for name, text in sources.items():
            (Path(folder) / name).write_text(text, encoding="utf-8")
        return made_library(Path(folder) / "fmu.c", ("-Os", "-s"))


def description(estimator: GripEstimator, guid: str, period: float, stiffness: float) -> str:
    """modelDescription.xml; period: s, of a sample."""
    about = {"fmiVersion": "2.0", "modelName": MODEL, "guid": guid}
    words = f"grip regulator for the finger {estimator.design}"
    root = xml.Element("fmiModelDescription", {**about, "description": words})
    can = {"canGetAndSetFMUstate": "true", "canNotUseMemoryManagementFunctions": "true"}
    unit = xml.SubElement(root, "CoSimulation", {"modelIdentifier": MODEL, **can})
    xml.SubElement(xml.SubElement(unit, "SourceFiles"), "File", name="fmu.c")
    units = xml.SubElement(root, "UnitDefinitions")
    for name in ("N", "mm", "N/mm", "microstrain"):
        xml.SubElement(units, "Unit", name=name)
    xml.SubElement(root, "DefaultExperiment", startTime="0", stepSize=repr(period))
    variables = xml.SubElement(root, "ModelVariables")
    gages = {f"reading[{k + 1}]": ("microstrain", "of a gage") for k in range(estimator.gages)}
    forces = {"normal_force": ("N", "F_n"), "tangential_force": ("N", "F_t")}
    reals = [("input", gages | forces), ("output", _OUTPUTS), ("parameter", _PARAMETERS)]
    place = 0
    for causality, named in reals:
        for name, (measured_in, words) in named.items():
            held = {} if causality == "parameter" else {"variability": "continuous"}
            start = repr(stiffness) if name == "stiffness" else "0"
            value = {"unit": measured_in} if measured_in else {}
            value |= {} if causality == "output" else {"start": start}
            _variable(variables, name, place, causality, words, "Real", value, held)
            place += 1
    _variable(
        variables,
        "delay",
        0,
        "parameter",
        "samples from a move until it is measured",
        "Integer",
        {"start": "0"},
        {},
    )
    discrete = {"variability": "discrete"}
    lifted = "the object has left its support"
    _variable(variables, "lifted", 0, "input", lifted, "Boolean", {"start": "false"}, discrete)
    _variable(variables, "unsure", 1, "output", "too little is known", "Boolean", {}, discrete)
    _variable(variables, "missed", 2, "output", "a sample held no number", "Boolean", {}, discrete)
    structure = xml.SubElement(root, "ModelStructure")
    for part in ("Outputs", "InitialUnknowns"):
        listed = xml.SubElement(structure, part)
        for number, each in enumerate(variables, 1):
            if each.get("causality") == "output":
                xml.SubElement(listed, "Unknown", index=str(number))
    xml.indent(root)
    return f'<?xml version="1.0" encoding="UTF-8"?>\n{xml.tostring(root, encoding="unicode")}\n'


def _variable(
    variables: xml.Element,
    name: str,
    place: int,
    causality: str,
    words: str,
    kind: str,
    value: dict[str, str],
    held: dict[str, str],
) -> None:
    about = {"name": name, "valueReference": str(place), "causality": causality}
    held = {"variability": "fixed"} if causality == "parameter" else held
    found = xml.SubElement(variables, "ScalarVariable", {**about, **held, "description": words})
    xml.SubElement(found, kind, value)
