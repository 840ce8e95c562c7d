"""Tables of design and scene files: frozen, strict, without unknown keys."""

from collections.abc import Iterable
from dataclasses import fields
from functools import cache
from typing import Annotated, Any, ClassVar, Self, TypeVar, get_type_hints

from pydantic import (
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Field,
    GetCoreSchemaHandler,
    GetJsonSchemaHandler,
    ValidationError,
    create_model,
    model_validator,
)
from pydantic.fields import FieldInfo
from pydantic_core import (
    CoreSchema,
    InitErrorDetails,
    PydanticCustomError,
    PydanticKnownError,
    core_schema,
)

from fingerdesign.errors import DesignError
from fingerdesign.runtime.registry import REFERENCE, Kind, Registry, is_reference, load_plugins

# Quotients of smaller positive values overflow or divide by zero. A nanometre, a nanonewton and a
# nanosecond are far below anything that a finger can show.
LEAST = 1e-9
_HOLDERS: dict[type["Table"], list[type["Table"]]] = {}  # Tables, and what is made of them.


class Table(BaseModel):
    """One frozen TOML table.

    Strict: strings and booleans are not numbers, whole numbers are accepted as floats, NaN and
    infinity are refused, and so is every key that the table does not name.
    """

    model_config = ConfigDict(
        strict=True, frozen=True, extra="forbid", allow_inf_nan=False, validate_default=True
    )

    @model_validator(mode="after")
    def _rules_hold(self) -> Self:
        errors = [InitErrorDetails(type=each, input=None) for each in self._misfits()]
        if errors:
            raise ValidationError.from_exception_data("rules of the table", errors)
        return self

    def _misfits(self) -> Iterable[PydanticCustomError]:
        """A refusal for each of the table's own rules between keys that it breaks."""
        return ()

    def __setstate__(self, state: dict[Any, Any]) -> None:
        """Restore a table in another process, where plug-ins may not be loaded yet."""
        load_plugins()
        super().__setstate__(state)


class Whole(Table):
    """A whole file's tables: before one is read, plug-ins are loaded, which may add to them."""

    @classmethod
    def __get_pydantic_core_schema__(
        cls, source: Any, handler: GetCoreSchemaHandler, /
    ) -> CoreSchema:
        """Load plug-ins for a holder of such tables: a record from JSON, a job of a study."""
        if cls.__pydantic_complete__:  # not while it is defined, or made again for a plug-in
            load_plugins()
        return handler(source)

    @classmethod
    def model_validate(cls, obj: Any, **options: Any) -> Self:
        load_plugins()
        return super().model_validate(obj, **options)

    @classmethod
    def model_validate_json(cls, json_data: str | bytes | bytearray, **options: Any) -> Self:
        load_plugins()
        return super().model_validate_json(json_data, **options)


def _as_tuple(value: Any) -> Any:
    """Turn the lists that TOML and JSON give into tuples, so that a frozen table stays frozen."""
    return tuple(value) if isinstance(value, list) else value


_T = TypeVar("_T")
_U = TypeVar("_U")
Pair = Annotated[tuple[_T, _U], BeforeValidator(_as_tuple)]
Row3 = Annotated[tuple[float, float, float], BeforeValidator(_as_tuple)]
Many = Annotated[tuple[_T, ...], BeforeValidator(_as_tuple)]


def key(default: Any, description: str, **more: Any) -> Any:
    """A key with its default and meaning; ``more``: bounds, examples, as of pydantic's Field."""
    return Field(default=default, description=description, **more)


def bounded(
    default: Any, least: float, most: float, description: str, *, example: Any = None
) -> Any:
    """A number's key with both its bounds allowed; ``example``: of one that may be absent."""
    examples = None if example is None else [example]
    return key(default, description, ge=least, le=most, examples=examples)


def positive(default: Any, most: float, description: str, least: float = LEAST) -> Any:
    """A number's key that is positive: at least ``least`` and at most ``most``."""
    return key(default, description, ge=least, le=most)


def refuse(value: object, bound: str, remedy: str, key: str = "") -> PydanticCustomError:
    """Return the error a validator raises to word its own fault.

    ``bound`` completes "must be ...", ``remedy`` is what to do; ``key`` (dotted) names the key
    when the validator sits on a whole table.
    """
    return PydanticCustomError(
        "fault", "{bound}; {remedy}", {"value": value, "bound": bound, "remedy": remedy, "key": key}
    )


def refuse_key(table: Table, key: str, bound: str, remedy: str) -> PydanticCustomError:
    """Refuse the value that a table holds under the last part of a dotted key (:func:`refuse`)."""
    value = getattr(table, key.rpartition(".")[2])
    return refuse("(absent)" if value is None else value, bound, remedy, key)


class Named:
    """Annotates a key that holds one of a registry's names; others are refused with the list."""

    def __init__(self, registry: Registry) -> None:
        self._registry = registry

    def __get_pydantic_core_schema__(
        self, source: object, handler: GetCoreSchemaHandler
    ) -> CoreSchema:
        return core_schema.no_info_plain_validator_function(self._known)

    def __get_pydantic_json_schema__(
        self, schema: CoreSchema, handler: GetJsonSchemaHandler
    ) -> dict[str, Any]:
        names: dict[str, Any] = {"enum": list(self._registry.names()), "type": "string"}
        own = {"pattern": REFERENCE, "type": "string"}
        return {"anyOf": [names, own]} if self._registry.refers else names

    def others(self) -> str:
        """The names that plug-ins brought, as words behind a key's description."""
        shipped = self._registry.shipped_names()
        names = [name for name in self._registry.names() if name not in shipped]
        return f"; of plug-ins: {' | '.join(names)}" if names else ""

    def _known(self, value: object) -> str:
        if is_reference(value):
            try:
                self._registry.find(value, "")
            except DesignError as error:
                raise refuse(value, error.faults[0].bound, error.faults[0].remedy) from None
        elif not self._registry.knows(value):
            *others, last = (repr(name) for name in self._registry.names())
            expected = f"{', '.join(others)} or {last}" if others else last
            raise PydanticKnownError("literal_error", {"expected": expected})
        return str(value)


def described(info: FieldInfo) -> str:
    """Return the meaning of a key, with the names that plug-ins added to its choices."""
    added = [each.others() for each in info.metadata if isinstance(each, Named)]
    return "".join([info.description or "", *added])


class OwnTable(Table):
    """A table that is made from a kind's dataclass, and pickled by it."""

    kind: ClassVar[type]

    def __reduce__(self) -> tuple[Any, ...]:
        return _blank, (self.kind,), self.__getstate__()


def _blank(kind: type) -> Table:
    made = table_of(kind)
    return made.__new__(made)


@cache
def table_of(kind: type) -> type[Table]:
    """The strict table of a kind's dataclass (see :func:`fingerdesign.runtime.registry.key`)."""
    types = get_type_hints(kind)
    made: dict[str, Any] = {
        each.name: (types[each.name], Field(default=each.default, **each.metadata))
        for each in fields(kind)
    }
    model = create_model(kind.__name__, __base__=OwnTable, __doc__=kind.__doc__, **made)
    model.kind = kind
    return model


def table_fields(model: type[Table], registry: Registry, before: str) -> None:
    """Give a table a key for the own table of every kind of a registry, now and later.

    The shipped kinds' tables are there with their defaults; that of a kind from outside is absent
    unless it is given, so that a plug-in that is not used changes no digest.
    """

    def add(kind: Kind) -> None:
        if kind.table is None or kind.table_name in model.__pydantic_fields__:
            return
        table, shipped = table_of(kind.table), kind.name in registry.shipped_names()
        info = FieldInfo.from_annotated_attribute(
            table if shipped else table | None,  # type: ignore[arg-type]
            Field(default_factory=table)
            if shipped
            else key(None, f"of the {registry.what} {kind.name}"),
        )
        known = model.__pydantic_fields__
        behind = {name: known.pop(name) for name in list(known)[list(known).index(before) :]}
        known |= {kind.table_name: info, **behind}
        rebuild(model)

    registry.watch(add)


def own_keys(registry: Registry, name: str | None = None) -> set[str]:
    """The own keys of every registered kind that is loaded, or of one."""
    kinds = [kind for kind in registry.loaded() if name is None or kind.name == name]
    return {each.name for kind in kinds if kind.table for each in fields(kind.table)}


def key_fields(model: type[Table], registry: Registry) -> None:
    """Give a table the own keys of every kind of a registry, now and later; absent unless given."""

    def add(kind: Kind) -> None:
        if kind.table is None:
            return
        for name, info in table_of(kind.table).model_fields.items():
            if name in model.__pydantic_fields__:
                raise ValueError(f"{kind.name}: there already is a key {name!r}")
            own = FieldInfo.from_annotated_attribute(
                Annotated[info.annotation | None, *info.metadata],  # type: ignore[operator,arg-type]
                key(None, f"{kind.name} only: {info.description}", examples=[info.default]),
            )
            model.__pydantic_fields__[name] = own
        rebuild(model)

    registry.watch(add)


def rebuild(model: type[Table]) -> None:
    """Make a table and its holders again, with the fields that were added."""
    model.model_rebuild(force=True)
    for other in _HOLDERS.get(model, ()):
        other.model_rebuild(force=True)


def holds(holder: type[Table], *tables: type[Table]) -> None:
    """Have ``holder`` rebuilt whenever one of ``tables`` in it is given a field."""
    for table in tables:
        _HOLDERS.setdefault(table, []).append(holder)
