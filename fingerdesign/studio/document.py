"""The TOML file that the studio watches: read, watched, and saved with its comments.

Moved sliders are stored as dotted keys, apart from the file's text. A change of the file by an
editor is taken over, and wins where it is of the same key.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from fingerdesign.checks.load import judge_design, with_values
from fingerdesign.design.io import read_text
from fingerdesign.design.keys import leaves, set_value
from fingerdesign.design.schema import Design
from fingerdesign.design.shipped import file_text
from fingerdesign.errors import DesignError, Fault
from fingerdesign.runtime.files import write_whole

SHIPPED = "maeno2000"  # what is shown where no design is named


def with_keys(text: str, values: Mapping[str, object]) -> str:
    """TOML ``text`` with dotted keys set, its comments and its order unchanged.

    >>> print(with_keys('[plates]  # bronze\\ncount = 15  # as in the paper', {"plates.count": 9}))
    [plates]  # bronze
    count = 9  # as in the paper
    """
    import tomlkit

    document = tomlkit.parse(text)
    for key, value in values.items():
        set_value(document, key, value)
    return tomlkit.dumps(document)


@dataclass
class Document:
    """One design's file, or a shipped design's text, and the keys that are not saved.

    path   where it is saved; of a shipped design NAME.toml in the working folder
    text   as it was last read
    unsaved  dotted key -> value
    """

    path: Path
    text: str
    folder: Path
    shipped: bool = False
    unsaved: dict[str, Any] = field(default_factory=dict)

    @classmethod
    def of(cls, name: Path | None) -> Document:
        """The file, or the shipped design of that name. Raises DesignError with every fault."""
        chosen = Path(SHIPPED) if name is None else name
        text = file_text(chosen)
        if chosen.is_file():
            found = cls(chosen, text, chosen.parent)
        else:
            found = cls(Path(f"{chosen}.toml"), text, Path(), shipped=True)
        found.design()
        return found

    def design(self) -> Design:
        """The design with what is unsaved. Raises DesignError with every fault."""
        saved = self.saved_design()
        return with_values(saved, self.unsaved) if self.unsaved else saved

    def saved_design(self) -> Design:
        """The design as the file has it. Raises DesignError with every fault."""
        return judge_design(self.text, str(self.path), self.folder).sound(str(self.path))

    def put(self, values: Mapping[str, Any]) -> None:
        """Take sliders' values: what equals the file's is not unsaved."""
        saved = dict(leaves(self.saved_design().model_dump(mode="json")))
        self.unsaved = {key: value for key, value in values.items() if saved.get(key) != value}

    def changed(self) -> bool:
        """Return True where the file has changed since it was read; its text is then taken over.

        A key that was changed in the file too is no longer unsaved. Raises DesignError where the
        file is gone, cannot be read, or holds a fault: the text before stays then.
        """
        if self.shipped:
            return False
        if not self.path.is_file():
            remedy = "Save writes it again" if not self.path.exists() else "move that away"
            raise DesignError([Fault("file", str(self.path), "there, an ordinary file", remedy)])
        text = read_text(self.path)
        if text == self.text:
            return False
        new = judge_design(text, str(self.path), self.folder).sound(str(self.path))
        was = dict(leaves(self.saved_design().model_dump(mode="json")))
        now = dict(leaves(new.model_dump(mode="json")))
        self.text = text
        self.unsaved = {
            key: value
            for key, value in self.unsaved.items()
            if was.get(key) == now.get(key) and now.get(key) != value
        }
        return True

    def save(self) -> Path:
        """Write the file with what is unsaved, comments unchanged; the path that was written.

        Raises DesignError where the result would be faulty, the file may not be written, or a
        shipped design's copy would overwrite a file; OSError as of the disk.
        """
        if self.shipped and self.path.exists():
            remedy = "open that file instead, or move it"
            raise DesignError([Fault("file", str(self.path), "a new file", remedy)])
        before = self.text
        if not self.shipped and self.path.is_file():
            if not self.path.stat().st_mode & 0o222:  # renaming would not ask
                remedy = "allow to write it, or copy it and open the copy"
                raise DesignError([Fault("file", str(self.path), "writable", remedy)])
            before = read_text(self.path)
            judge_design(before, str(self.path), self.folder)  # it may be no TOML by now
        text = with_keys(before, self.unsaved)
        judge_design(text, str(self.path), self.folder).sound(str(self.path))
        write_whole(self.path, text)
        self.text, self.unsaved, self.shipped = text, {}, False
        return self.path
