"""The options of a plugin: a pydantic model in which every field has a help text and a unit."""

import reprlib
from collections.abc import Mapping
from types import NoneType, UnionType
from typing import Annotated, Any, Literal, Union, get_args, get_origin

from pydantic import BaseModel, ConfigDict, Discriminator, Field, ValidationError
from pydantic.fields import FieldInfo

MAX_SEED = 2**63 - 1
"""Largest seed, the largest integer of TOML and of a database."""


class Table(BaseModel):
    """A table of a study file: unknown keys are errors; values are validated and frozen."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)
    """Configuration of pydantic; numbers must be finite."""


def option(default: Any, help: str, unit: str = "", **constraints: Any) -> Any:
    """Return one field of a :class:`Table`.

    Args:
        default: value if a study file does not set the option; ``...`` for a required option.
        help: help text that ``driftform plugins show`` prints, one sentence.
        unit: unit of the value in a study file, ``""`` for a dimensionless one.
        constraints: pydantic constraints such as ``ge=0, le=1``. Give every number a lower and an upper bound: what
            lies beyond costs hours, memory or sense.
    """
    if isinstance(default, int | float):
        # Neither true nor "1000" is accepted as a number.
        constraints.setdefault("strict", True)
    return Field(default, description=help, json_schema_extra={"unit": unit}, **constraints)


def read_kind(usual: str) -> Discriminator:
    """Return what chooses a table of a union by its ``kind``, which is ``usual`` where a study file has none."""
    return Discriminator(
        lambda value: value.get("kind", usual) if isinstance(value, Mapping) else getattr(value, "kind", None)
    )


def list_kinds(union: Any) -> dict[str, type[Table]]:
    """Return the tables of a union whose members have tags, by these."""
    return {member.__metadata__[0].tag: member.__origin__ for member in get_args(get_args(union)[0])}


def describe(model: type[BaseModel]) -> list[dict[str, Any]]:
    """Return rows ``{option, type, bounds, default, unit, help}``, one for each field of a model.

    The fields of a table within the model follow it, with names such as ``kit.joint``.
    """
    rows: list[dict[str, Any]] = []
    for name, field in model.model_fields.items():
        extra = field.json_schema_extra if isinstance(field.json_schema_extra, dict) else {}
        rows.append(
            {
                "option": name,
                "type": _format_type(field.annotation),
                "bounds": describe_bounds(field),
                "default": "required" if field.is_required() else field.get_default(call_default_factory=True),
                "unit": extra.get("unit", ""),
                "help": field.description or "",
            }
        )
        if table := find_table(field.annotation):
            rows += [row | {"option": f"{name}.{row['option']}"} for row in describe(table)]
    return rows


def describe_bounds(field: FieldInfo) -> str:
    """Return the bounds of a number, such as ``> 0, ≤ 1``; empty without any."""
    signs = (("gt", ">"), ("ge", "≥"), ("lt", "<"), ("le", "≤"))
    return ", ".join(
        f"{sign} {getattr(item, name):g}"
        for item in field.metadata
        for name, sign in signs
        if getattr(item, name, None) is not None
    )


def check_defaults(model: type[Table]) -> None:
    """Check that a model accepts its own defaults, which pydantic does not.

    Raises ValueError with the option and the reason.
    """
    defaults = {
        name: field.get_default(call_default_factory=True)
        for name, field in model.model_fields.items()
        if not field.is_required()
    }
    try:
        model.model_validate(defaults)
    except ValidationError as error:
        for item in error.errors(include_url=False):
            if item["type"] != "missing":
                reason = item["msg"].replace("Input should be", "should be")
                path = ".".join(map(str, item["loc"]))
                what = f"option '{path}' has the default {reprlib.repr(item['input'])}" if path else "its defaults"
                raise ValueError(f"{what}: {reason}") from None


def find_table(annotation: Any) -> type[Table] | None:
    """Return the model of a field that holds a table, or a table or nothing; ``None`` for other fields."""
    candidates = (annotation, *(get_args(annotation) if get_origin(annotation) in (Union, UnionType) else ()))
    return next((c for c in candidates if isinstance(c, type) and issubclass(c, Table)), None)


def _format_type(annotation: Any) -> str:
    """Return a type in readable form: ``float``, ``'first' or 'last'``, ``[float, float, float]``."""
    origin, arguments = get_origin(annotation), get_args(annotation)
    if origin is Annotated:
        return _format_type(arguments[0])
    if origin is Literal:
        return " or ".join(map(repr, arguments))
    if origin in (Union, UnionType):
        return " or ".join("none" if part is NoneType else _format_type(part) for part in arguments)
    if origin is tuple and arguments[1:] == (Ellipsis,):
        return f"list of {_format_type(arguments[0])}"
    if origin is tuple:
        return f"[{', '.join(map(_format_type, arguments))}]"
    return "table" if find_table(annotation) else str(getattr(annotation, "__name__", annotation))
