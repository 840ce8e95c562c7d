"""Shipped designs, scenes and studies by name, and files that come before them."""

from difflib import get_close_matches
from functools import lru_cache
from importlib import resources
from importlib.resources.abc import Traversable
from pathlib import Path

from fingerdesign.design.io import parse_scene, parse_toml, read_text
from fingerdesign.design.scene import Scene
from fingerdesign.errors import DesignError, Fault
from fingerdesign.runtime.registry import unknown_name

ESTIMATOR_SUFFIX = ".estimator.json"


def _folder(kind: str) -> Traversable:
    """Return the folder of the shipped files of a kind: in the installed package, or in the
    checkout."""
    installed = resources.files("fingerdesign") / "data" / "designs"
    designs = installed if installed.is_dir() else Path(__file__).resolve().parents[2] / "designs"
    return designs if kind == "design" else designs / {"scene": "scenes", "study": "studies"}[kind]


@lru_cache(maxsize=1)
def estimator_texts() -> dict[str, str]:
    """Texts of the estimators that ship with designs, by the design's name, in order."""
    files = [each for each in _folder("design").iterdir() if each.name.endswith(ESTIMATOR_SUFFIX)]
    texts = {each.name.removesuffix(ESTIMATOR_SUFFIX): each.read_text("utf-8") for each in files}
    return dict(sorted(texts.items()))


def shipped_names(kind: str = "design") -> tuple[str, ...]:
    """List the shipped designs, scenes or studies, in alphabetical order. kind: which of them."""
    files = (entry.name for entry in _folder(kind).iterdir() if entry.is_file())
    return tuple(sorted(name.removesuffix(".toml") for name in files if name.endswith(".toml")))


def kind_of(file_or_name: str | Path) -> str:
    """Tell the kind of a file or of a shipped name: a "design", a "scene" or a "study".

    A file is known by its tables; one that cannot be read, and an unknown name that is near to none
    of another kind, is taken for a design, whose reading reports the fault.
    """
    path, kinds = Path(file_or_name), ("design", "scene", "study")
    if path.is_file():
        try:
            tables = set(parse_toml(read_text(path)))
        except DesignError:
            return "design"
        if "study" in tables and "design" not in tables:
            return "study"
        own = {"object", "path", "readout"}
        return "scene" if tables and tables <= own | {"assumed"} and tables & own else "design"
    near: list[str] = []
    for kind in kinds:
        if str(path) in shipped_names(kind):
            return kind
        near += [kind] if get_close_matches(path.stem, shipped_names(kind), 1) else []
    return near[0] if near else "design"


def shipped_text(name: str, kind: str = "design") -> str:
    """Return the text of a shipped design or scene. DesignError for an unknown name."""
    known = shipped_names(kind)
    if name not in known:
        raise DesignError([unknown_name(name, "--from", known)])
    return (_folder(kind) / f"{name}.toml").read_text("utf-8")


def shipped_path(name: str) -> Path:
    """Return the path of a shipped design's file."""
    shipped_text(name)
    return Path(str(_folder("design") / f"{name}.toml"))


def load_scene(file_or_name: str | Path) -> Scene:
    """Return the scene of a file, or the shipped one of that name where there is no such file.
    Raises :class:`DesignError` with every fault of the file."""
    return parse_scene(file_text(file_or_name, "scene"), str(file_or_name))


def file_text(file_or_name: str | Path, kind: str = "design") -> str:
    """Return the text of a design's or scene's file, or of the shipped one of that name. A file
    comes first; of a folder of that name (a result's) no design can be read."""
    path, known = Path(file_or_name), shipped_names(kind)
    if not path.is_file() and str(path) in known:
        return shipped_text(str(path), kind)
    if path.exists():
        return read_text(path)
    whole = path.with_name(f"{path.name}.toml")
    near = [str(whole)] if whole.is_file() else get_close_matches(path.stem, known, 1)
    remedy = f"there is no such file; {f'did you mean {near[0]}?' if near else 'check the path'}"
    bound = f"a readable TOML file or a shipped {kind} ({', '.join(known)})"
    raise DesignError([Fault("file", str(path), bound, remedy)])
