"""The TOML file that the studio watches: read, watched, and saved with its comments.

Changes are stored as dotted keys, apart from the file's text. A change of the file by an editor is
taken over, and wins where it is of the same key.
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Self

from fingerdesign.checks.load import judge_design, with_values
from fingerdesign.design.faults import shown
from fingerdesign.design.io import dump_design, read_text
from fingerdesign.design.keys import leaves, set_value
from fingerdesign.design.schema import Design
from fingerdesign.design.shipped import file_text
from fingerdesign.errors import DesignError, Fault
from fingerdesign.runtime.files import write_whole
from fingerdesign.search.passing.space import changes_between

SHIPPED = "maeno2000"  # what is shown where no design is named


def with_keys(text: str, values: Mapping[str, object]) -> str:
    """TOML ``text`` with dotted keys set, its comments and its order unchanged. A key that is set
    is no longer ``assumed``.

    >>> print(with_keys('[plates]  # bronze\\ncount = 15  # as in the paper', {"plates.count": 9}))
    [plates]  # bronze
    count = 9  # as in the paper
    """
    import tomlkit

    document = tomlkit.parse(text)
    for key, value in values.items():
        set_value(document, key, value)
        if key in (assumed := document.get("assumed", ())):
            assumed.remove(key)
    return tomlkit.dumps(document)


def edited_text(text: str, before: Design, after: Design, folder: Path) -> str:
    """The text of ``before`` with the changed keys set; the whole design written again where that
    does not read back as the same finger from the folder. A comment behind a changed value was
    written for the former one, which takes its place."""
    values = changed_values(before, after)
    if before.design.name != after.design.name:
        values["design.name"] = after.design.name
    try:
        edited = _former_values(with_keys(text, values), before, values)
        if _same_finger(judge_design(edited, folder=folder).sound(""), after):
            return edited
    except (DesignError, ValueError, KeyError):
        pass  # What TOML's editor cannot set in place is written as a whole.
    return dump_design(after)


def _former_values(text: str, before: Design, changed: Iterable[str]) -> str:
    """The text with the former value as the comment of each changed key that has a comment."""
    import tomlkit
    from tomlkit.items import Item

    document = tomlkit.parse(text)
    former = dict(leaves(before.model_dump(mode="json", exclude_none=True)))
    for key, item in leaves(document):
        if key in changed and isinstance(item, Item) and item.trivia.comment:
            item.trivia.comment = f"# was {shown(former.get(key))}"
    return tomlkit.dumps(document)


def _same_finger(first: Design, second: Design) -> bool:
    """True if two designs differ in materials alone that no part is made of."""
    own = dict(leaves(second.model_dump(mode="json", exclude_none=True)))
    used = [f"materials.{name}." for key, name in own.items() if key.endswith(".material")]
    differ = changed_values(first, second)
    return all(k.startswith("materials.") and not k.startswith(tuple(used)) for k in differ)


def changed_values(before: Design, after: Design) -> dict[str, Any]:
    """Dotted key -> new value; None takes away a key that ``before`` has."""
    known = dict(leaves(before.model_dump(mode="json", exclude_none=True)))
    changes = {key: new for key, (_, new) in changes_between(before, after).items()}
    return {key: new for key, new in changes.items() if new is not None or key in known}


@dataclass
class Document:
    """One design's file, or a shipped design's text, and the keys that are not saved.

    path   where it is saved; of a shipped design NAME.toml in the working folder
    text   as it was last read
    draft  a whole text in place of it, not saved; None: there is none
    unsaved  dotted key -> value, over the draft or the text
    """

    path: Path
    text: str
    folder: Path
    shipped: bool = False
    unsaved: dict[str, Any] = field(default_factory=dict)
    draft: str | None = None
    _judged: tuple[str, Design] | None = None

    @classmethod
    def of(cls, name: Path | None) -> Self:
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
        base = self._base()
        return with_values(base, self.unsaved) if self.unsaved else base

    def _base(self) -> Design:
        """The design below the unsaved keys."""
        return self.saved_design() if self.draft is None else self._sound(self.draft)

    def _sound(self, text: str) -> Design:
        """The design of a text, judged once: sliders ask for it at each move."""
        if self._judged is None or self._judged[0] != text:
            self._judged = (
                text,
                judge_design(text, str(self.path), self.folder).sound(str(self.path)),
            )
        return self._judged[1]

    def saved_design(self) -> Design:
        """The design as the file has it. Raises DesignError with every fault."""
        return self._sound(self.text)

    def changes(self) -> int:
        """Number of keys that differ from the file's."""
        if self.draft is None:
            return len(self.unsaved)
        return len(changed_values(self.saved_design(), self.design()))

    def put(self, values: Mapping[str, Any]) -> None:
        """Take values of keys: what equals the file's is not unsaved."""
        base = dict(leaves(self._base().model_dump(mode="json")))
        for key, value in values.items():
            if base.get(key) == value:
                self.unsaved.pop(key, None)
            else:
                self.unsaved[key] = value

    def take(self, design: Design) -> None:
        """Take a whole design: its changed keys, or its text where keys do not describe it."""
        saved = self.saved_design()
        values = changed_values(saved, design)
        try:
            same = with_values(saved, values).digest() == design.digest()
        except DesignError:
            same = False
        if same:
            self.draft, self.unsaved = None, values
        else:
            self.draft, self.unsaved = dump_design(design), {}

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
        self.text, self.draft = text, None
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
        text = with_keys(before if self.draft is None else self.draft, self.unsaved)
        judge_design(text, str(self.path), self.folder).sound(str(self.path))
        write_whole(self.path, text)
        self.text, self.draft, self.unsaved, self.shipped = text, None, {}, False
        return self.path
