"""Effects from a scenario's tables: checked, in the order of the chain, and back to tables."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Annotated, Any

from pydantic import (
    AfterValidator,
    ConfigDict,
    Field,
    GetCoreSchemaHandler,
    GetJsonSchemaHandler,
    TypeAdapter,
    ValidationError,
    WithJsonSchema,
    create_model,
)
from pydantic.json_schema import JsonSchemaValue
from pydantic_core import CoreSchema, core_schema

from scenarios.errors import InputError
from scenarios.problems import misfit, only_problem, problem_at
from sim.effects.base import Effect
from sim.effects.registry import BY_NAME, nearest, summary

Path = tuple[str | int, ...]


class Effects(Mapping[str, tuple[Effect, ...]]):
    """The `effects` tables of a scenario: name -> effects of the name, from a table or an array of tables.

    Parameters
    ----------
    written : name -> table of parameters, or array of tables, as the user wrote them. A scenario is stored with the
        tables as written: nothing is added, nothing reordered.

    Raises pydantic's ValidationError with the place of the first unknown effect or parameter, or wrong value.
    """

    def __init__(self, written: Mapping[str, Any] | None = None) -> None:
        self.written = dict(written or {})
        self._made = {name: tuple(_instances(name, table)) for name, table in self.written.items()}

    def __getitem__(self, name: str) -> tuple[Effect, ...]:
        return self._made[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._made)

    def __len__(self) -> int:
        return len(self._made)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Effects) and self.written == other.written

    __hash__ = None  # type: ignore[assignment]

    def __repr__(self) -> str:
        return f"Effects({self.written!r})"

    @classmethod
    def __get_pydantic_core_schema__(cls, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        def checked(value: Any) -> Effects:
            if isinstance(value, Effects):
                return value
            if not isinstance(value, Mapping):
                raise misfit((), f"expected tables by effect name, found {value!r}", "write [effects.NAME]")
            return cls(value)

        written = core_schema.plain_serializer_function_ser_schema(lambda effects: effects.written)
        return core_schema.no_info_plain_validator_function(checked, ref="Effects", serialization=written)

    @classmethod
    def __get_pydantic_json_schema__(cls, schema: CoreSchema, handler: GetJsonSchemaHandler) -> JsonSchemaValue:
        """Under each name a table, or an array of tables."""
        tables: dict[str, Any] = {
            name: (kind | list[kind], Field(title=name, description=summary(name)))  # type: ignore[valid-type]
            for name, kind in BY_NAME.items()
        }
        written = create_model("Effects", __config__=ConfigDict(extra="forbid"), **tables)
        shown = handler.resolve_ref_schema(handler(written.__pydantic_core_schema__))
        return {key: value for key, value in shown.items() if key != "required"}


def _known(name: str) -> str:
    if name not in BY_NAME:
        raise misfit((), f"no effect {name!r}", nearest(name))
    return name


EffectName = Annotated[str, AfterValidator(_known), WithJsonSchema({"type": "string", "enum": list(BY_NAME)})]


def in_order(groups: Sequence[Effects], order: Sequence[str] | None) -> tuple[Effect, ...]:
    """The effects of several tables in the physical order, or in the given order of names."""
    names = tuple(BY_NAME) if order is None else order
    return tuple(effect for name in names for group in groups for effect in group.get(name, ()))


def check_order(order: Sequence[str] | None, present: Iterable[str]) -> None:
    """Check that an order names every effect present, each once; ValidationError at `effect_order` otherwise."""
    for name in order or ():
        if list(order or ()).count(name) > 1:
            raise misfit(("effect_order",), f"{name} is named twice")
    missing = [] if order is None else [name for name in present if name not in order]
    if missing:
        do = "name every effect of the scenario"
        raise misfit(("effect_order",), f"does not name {', '.join(missing)}", do)


def build(tables: Mapping[str, Any], order: Sequence[str] | None = None, where: str = "") -> tuple[Effect, ...]:
    """The effects of tables in the chain's order, see `Effects` and `in_order`.

    Raises InputError with place: unknown effect or parameter, wrong type or shape, not finite, out of range,
    incomplete order. where : the file, for messages.
    """
    try:
        group = Effects(tables)
    except ValidationError as error:
        raise _refused(error, where, ("effects",)) from None
    try:
        for name in order or ():
            _known(name)
        check_order(order, group)
    except ValidationError as error:
        raise _refused(error, where, ()) from None
    return in_order([group], order)


def as_tables(effects: Sequence[Effect]) -> tuple[dict[str, Any], tuple[str, ...]]:
    """Tables and order, the inverse of `build`; InputError unless effects of one kind follow each other."""
    names = tuple(dict.fromkeys(effect.name for effect in effects))
    grouped = {name: [table(effect) for effect in effects if effect.name == name] for name in names}
    if [effect.name for effect in effects] != [name for name in names for _ in grouped[name]]:
        raise InputError("effects of one kind must follow each other", where="effects", do="reorder them")
    return {name: parts[0] if len(parts) == 1 else parts for name, parts in grouped.items()}, names


def table(effect: Effect) -> dict[str, Any]:
    """The effect as a table for TOML: parameters of the forms in use, tuples as lists, the active window if any."""
    plain: dict[str, Any] = TypeAdapter(type(effect)).dump_python(effect, mode="json", exclude_none=True)
    idle = {p.name for p in effect.parameters() if p.form not in effect.forms_in_use}
    return {name: value for name, value in plain.items() if name not in idle}


def _instances(name: str, given: Any) -> Iterator[Effect]:
    several = list(given) if isinstance(given, list | tuple) else [given]
    if not all(isinstance(one, Mapping) for one in several):
        do = f"write [effects.{name}] and its parameters below"
        raise misfit((name,), f"an effect is a table of parameters, or an array of tables; found {given!r}", do)
    if name not in BY_NAME:
        raise misfit((name,), "no effect of this name", nearest(name))
    for i, one in enumerate(several):
        yield _made((name,) if several == [given] else (name, i), one)


def _made(place: Path, given: Mapping[str, Any]) -> Effect:
    name = str(place[0])
    try:
        return BY_NAME[name](**given)
    except InputError as error:
        parameter = error.where.removeprefix(name).removeprefix(".")
        raise misfit((*place, *filter(None, (parameter,))), error.what, error.do) from None


def _refused(error: ValidationError, where: str, prefix: Path) -> InputError:
    path, what, do = only_problem(error)
    return problem_at(where, (*prefix, *path), what, do)
