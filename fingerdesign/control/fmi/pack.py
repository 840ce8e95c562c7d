"""A functional mock-up unit of any content: its description, its library, its zip.

A zip of modelDescription.xml, sources/ (what the first file includes with it), resources/, and on
Linux with a compiler the library, for x86-64 or AArch64. What the units' C has in common is
templates/fmi2.c.
"""

import hashlib
import io
import platform
import sys
import tempfile
import zipfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from xml.etree import ElementTree as xml

from fingerdesign.runtime.native import made_library

_PLATFORMS = {"x86_64": "linux64", "aarch64": "aarch64-linux"}
WITHOUT_LIBRARY = "no library, as no C compiler was found: build it from the sources inside"
_UNITS = ("N", "mm", "N/mm", "N.mm", "g", "microstrain")
_EPOCH = (1980, 1, 1, 0, 0, 0)  # The same unit is the same bytes.


@dataclass(frozen=True)
class Variable:
    """One of a unit's variables. causality: input, output or parameter; kind: Real, Integer or
    Boolean; those of a kind are numbered in their order. start: of all but outputs."""

    name: str
    causality: str
    words: str
    unit: str = ""
    kind: str = "Real"
    start: str = "0"


@dataclass(frozen=True)
class Unit:
    """Name and words of a unit, its variables, and the length of its steps, s."""

    model: str
    words: str
    variables: Sequence[Variable]
    period: float

    def packed(
        self, sources: Mapping[str, str], resources: Mapping[str, bytes], flags: tuple[str, ...]
    ) -> bytes:
        """The file. sources: the first one is compiled, with ``flags``; @guid@ in it is filled."""
        main = next(iter(sources))
        digest = hashlib.sha256("".join(sources.values()).encode())
        for content in resources.values():
            digest.update(content)
        cut = digest.hexdigest()
        guid = f"{{{'-'.join((cut[:8], cut[8:12], cut[12:16], cut[16:20], cut[20:32]))}}}"
        texts = {**sources, main: sources[main].replace("@guid@", guid)}
        files = {f"sources/{name}": text.encode() for name, text in texts.items()}
        files |= {f"resources/{name}": content for name, content in resources.items()}
        files["modelDescription.xml"] = self.description(guid, main).encode()
        system = _PLATFORMS.get(platform.machine()) if sys.platform == "linux" else None
        if system is not None and (library := _compiled(texts, flags)) is not None:
            files[f"binaries/{system}/{self.model}.so"] = library
        stream = io.BytesIO()
        with zipfile.ZipFile(stream, "w", zipfile.ZIP_DEFLATED) as archive:
            for name in sorted(files):
                about = zipfile.ZipInfo(name, _EPOCH)
                archive.writestr(about, files[name], zipfile.ZIP_DEFLATED, compresslevel=9)
        return stream.getvalue()

    def description(self, guid: str, source: str) -> str:
        """modelDescription.xml; source: the file that is compiled."""
        about = {"fmiVersion": "2.0", "modelName": self.model, "guid": guid}
        root = xml.Element("fmiModelDescription", {**about, "description": self.words})
        can = {"canGetAndSetFMUstate": "true", "canNotUseMemoryManagementFunctions": "true"}
        unit = xml.SubElement(root, "CoSimulation", {"modelIdentifier": self.model, **can})
        xml.SubElement(xml.SubElement(unit, "SourceFiles"), "File", name=source)
        units = xml.SubElement(root, "UnitDefinitions")
        for name in _UNITS:
            xml.SubElement(units, "Unit", name=name)
        xml.SubElement(root, "DefaultExperiment", startTime="0", stepSize=repr(self.period))
        variables = xml.SubElement(root, "ModelVariables")
        places = dict.fromkeys(("Real", "Integer", "Boolean"), 0)
        for each in self.variables:
            _describe(variables, each, places[each.kind])
            places[each.kind] += 1
        structure = xml.SubElement(root, "ModelStructure")
        for part in ("Outputs", "InitialUnknowns"):
            listed = xml.SubElement(structure, part)
            for number, variable in enumerate(self.variables, 1):
                if variable.causality == "output":
                    xml.SubElement(listed, "Unknown", index=str(number))
        xml.indent(root)
        return f'<?xml version="1.0" encoding="UTF-8"?>\n{xml.tostring(root, encoding="unicode")}\n'


def systems_of(content: bytes) -> list[str]:
    """FMI's names of the systems that a unit's file has a library for."""
    with zipfile.ZipFile(io.BytesIO(content)) as archive:
        names = [each.split("/") for each in archive.namelist()]
    return [each[1] for each in names if each[0] == "binaries"]


def _describe(variables: xml.Element, each: Variable, place: int) -> None:
    about = {"name": each.name, "valueReference": str(place), "causality": each.causality}
    changes = "continuous" if each.kind == "Real" else "discrete"
    about["variability"] = "fixed" if each.causality == "parameter" else changes
    found = xml.SubElement(variables, "ScalarVariable", {**about, "description": each.words})
    value = {"unit": each.unit} if each.unit else {}
    value |= {} if each.causality == "output" else {"start": each.start}
    xml.SubElement(found, each.kind, value)


def _compiled(sources: Mapping[str, str], flags: tuple[str, ...]) -> bytes | None:
    with tempfile.TemporaryDirectory() as folder:
        for name, text in sources.items():
            (Path(folder) / name).write_text(text, encoding="utf-8")
        return made_library(Path(folder) / next(iter(sources)), flags)
