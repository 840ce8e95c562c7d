"""``fingerdesign new``: a commented starter design, scene or study."""

import errno
import re
import shlex
from dataclasses import dataclass, replace
from pathlib import Path

import click
from pydantic import TypeAdapter

from fingerdesign.checks.load import load_design, with_values
from fingerdesign.design import starter
from fingerdesign.design.faults import shown
from fingerdesign.design.schema import schema_text
from fingerdesign.errors import DesignError, Fault
from fingerdesign.records.verdict import SIGNS
from fingerdesign.runtime.files import why_no_place, write_whole
from fingerdesign.search.passing.atlas import PROCESSES, SOURCES, Entry, Request, nearest, unmet
from fingerdesign.studio.document import with_keys
from fingerdesign_cli.options import Options, masses_of
from fingerdesign_cli.terminal import as_json, print_json, quiet, say, say_marked

MASS = "grip.object_mass_g"
FLAGSHIP = "film_tees"  # Plain `new` copies it: it passes all verdicts, and its keys are few.


@dataclass(frozen=True)
class Wish(Options):
    """Purpose of the finger, as text; None: anything."""

    lift: str | None
    gages: str | None
    process: str | None

    @property
    def given(self) -> bool:
        """True if anything was requested."""
        return (self.lift, self.gages, self.process) != (None, None, None)

    def request(self) -> Request:
        """The request. DesignError with every fault."""
        faults: list[Fault] = []
        masses: tuple[float, ...] = ()
        gages, process = ("--gages", self.gages, SOURCES), ("--process", self.process, PROCESSES)
        for option, value, choices in (gages, process):
            if value is not None and value not in choices:
                bound = f"one of {', '.join(choices)}"
                faults.append(Fault(option, shown(value), bound, "choose one of them"))
        if self.lift is not None:
            given = masses_of(self.lift)
            if given is None:
                bound = "a mass or a range in grams"
                faults.append(Fault("--lift", shown(self.lift), bound, "write 500g or 50..500g"))
            try:
                masses = with_values(load_design(FLAGSHIP), {MASS: given}).grip.masses_g
            except DesignError as error:
                own = [replace(each, key=each.key.replace(MASS, "--lift")) for each in error.faults]
                faults += own if given is not None else []
        if faults:
            raise DesignError(faults)
        return Request(masses, self.gages, self.process)


@dataclass(frozen=True)
class Kind(Options):
    """Kind of file that is written; whole, short: of a design all keys, or the first fifteen."""

    scene: bool
    study: bool
    whole: bool
    short: bool

    @property
    def word(self) -> str:
        """The kind of file: scene, study or design."""
        return "scene" if self.scene else "study" if self.study else "design"

    def refuse(self, source: str | None, wish: Wish) -> None:
        """Raise a usage error where options exclude each other."""
        given = (self.scene, self.study, self.whole, self.short)
        if sum(given) > 1 or (source is not None and (self.whole or self.short)):
            words = "give one of --scene, --study, --all, --short; the last two go without --from"
            raise click.UsageError(words)
        if wish.given and (sum(given) or source is not None):
            words = "--lift, --gages and --process write a design: give no other kind"
            raise click.UsageError(words)


def new(file: Path, source: str | None, form: Kind, wish: Wish, force: bool) -> int:
    """Write a commented starter design to FILE.toml, its name taken from FILE; or another file."""
    form.refuse(source, wish)
    request = wish.request() if wish.given else None
    entry = None if request is None else nearest(request)
    _refuse(file, force)
    name = re.sub(r"[^A-Za-z0-9_-]+", "-", file.stem).strip("-")[:64] or "finger"
    made = "" if file.parent.exists() else f" in the new folder {file.parent}"
    file.parent.mkdir(parents=True, exist_ok=True)
    text = _text(name, source, form) if entry is None else _entry_text(entry, name, wish.process)
    write_whole(file, text)
    if not form.study:
        made = _schema(file.parent / f"{form.word}.schema.json", form.word, force, made)
    if entry is not None and request is not None:
        return _say(entry, request, file, made)
    if not quiet():
        design = "DESIGN --scene " if form.scene else ""
        click.echo(f"{file} written{made}")
        click.echo(f"next: fingerdesign check {design}{shlex.quote(str(file))}")
    return 0


def _schema(schema: Path, word: str, force: bool, made: str) -> str:
    """Write the schema where there is none; ``made``, what else was made, with it."""
    if schema.exists() and not force:
        return made
    write_whole(schema, schema_text(word))
    return f" with {schema.name}, by which editors explain keys{made and ','}{made}"


def _wrong_name(file: Path) -> str:
    """Fault of a file's name, with the remedy; "" where nothing is."""
    if file.suffix != ".toml":
        hidden = file.name.startswith(".")  # as of .toml alone
        other = file.with_suffix(".toml") if file.name and not hidden else Path("finger.toml")
        return f"must end in .toml; try {other}"
    try:
        file.lstat()
    except OSError as error:
        if error.errno == errno.ENAMETOOLONG:
            return "must be a name that the disk takes; choose a shorter one"
    if file.is_symlink() and not file.exists():
        return "is a link to nothing; choose another name"
    return ""


def _refuse(file: Path, force: bool) -> None:
    if wrong := _wrong_name(file):
        raise click.UsageError(f"FILE = {file}: {wrong}")
    if file.exists() and not file.is_file():
        raise click.UsageError(f"FILE = {file}: must be a regular file; choose another name")
    if file.exists() and not force:
        raise click.UsageError(f"FILE = {file}: must not exist; choose another name or --force")
    if why := why_no_place(file.parent):
        wrong = f"must be in a folder that can be written into, and {why}"
        raise click.UsageError(f"FILE = {file}: {wrong}; choose another")


def _entry_text(entry: Entry, name: str, process: str | None) -> str:
    """The entry's design with its keys and the mold's process set, and its own opening comment."""
    values = dict(entry.values) | ({} if process is None else {"mold.process": process})
    plain = {key: [*v] if isinstance(v, tuple) else v for key, v in values.items()}
    text = with_keys(starter.starter_text(name, entry.design), plain)
    head = [f"# {each.sign} {each.name}: {each.number}; {each.target}" for each in entry.verdicts]
    first = f"# From the atlas: {entry.name}, which {entry.words}."
    found = f"# In 3-D ({entry.mesher}), at commit {entry.commit}:"
    return "\n".join([first, found, *head, text[text.index("#:schema") :]])


def _say(entry: Entry, request: Request, file: Path, made: str) -> int:
    """Print what the entry does not meet, which it is, and its verdicts; 1 where it lacks any."""
    missing = list(unmet(entry, request))
    code = 1 if missing else 0
    if as_json():
        plain = TypeAdapter(Entry).dump_python(entry, mode="json")
        print_json({"file": str(file), "entry": plain, "unmet": missing})
        return code
    for sentence in missing:
        click.echo(f"{SIGNS['fail']} not met: {sentence}", err=True)
    if quiet():
        return code
    nearest_one = ", the nearest verified finger," if missing else ""
    click.echo(f"{file} written{made}")
    click.echo(f"{entry.name} of the atlas{nearest_one} {entry.words}")
    for each in entry.verdicts:
        say_marked(each.sign, f"{each.name}: {each.number}; {each.target}")
    for process, mold in entry.molds.items():
        if request.process in (None, process):
            say_marked(SIGNS["pass" if mold.ready else "note"], f"{process}: {mold.words}")
    if request.masses_g and missing:
        say(f"to search for it: edit {MASS}, then fingerdesign optimise {shlex.quote(str(file))}")
    click.echo(f"next: fingerdesign check {shlex.quote(str(file))}")
    return code


def _text(name: str, source: str | None, form: Kind) -> str:
    if form.scene:
        return starter.starter_scene_text(source)
    if form.study:
        return starter.starter_study_text(name, source)
    if form.short:
        return starter.starter_short_text(name)
    return starter.starter_text(name, None if form.whole else source or FLAGSHIP)
