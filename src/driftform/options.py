"""The options of a plugin: a pydantic model whose every field tells its unit and what it does."""

from types import NoneType, UnionType
from typing import Annotated, Any, Literal, Union, get_args, get_origin

from pydantic import BaseModel, ConfigDict, Field


class Table(BaseModel):
    """A table of a study file: unknown keys are errors, values are checked and frozen."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)
    """Of pydantic; numbers are finite."""


def option(default: Any, help: str, unit: str = "", **constraints: Any) -> Any:
    """One field of a :class:`Table`.

    Parameters
    ----------
    default
        the value where a study file says nothing.
    help
        one sentence for ``driftform plugins show``.
    unit
        the unit of the value as it stands in the file, ``""`` where it has none.
    constraints
        pydantic constraints such as ``gt=0``.
    """
    if isinstance(default, int | float):
        # A number is a number: neither true nor "1000" is one.
        constraints.setdefault("strict", True)
    return Field(default, description=help, json_schema_extra={"unit": unit}, **constraints)


def describe(model: type[BaseModel]) -> list[dict[str, Any]]:
    """Rows ``{option, type, default, unit, help}``, one for each field of a model."""
    rows = []
    for name, field in model.model_fields.items():
        extra = field.json_schema_extra if isinstance(field.json_schema_extra, dict) else {}
        rows.append(
            {
                "option": name,
                "type": _format_type(field.annotation),
                "default": "required"
                if field.is_required()
                else field.get_default(call_default_factory=True),
                "unit": extra.get("unit", ""),
                "help": field.description or "",
            }
        )
    return rows


def _format_type(annotation: Any) -> str:
    """A type as a person writes it: ``float``, ``'first' or 'last'``, ``[float, float, float]``."""
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
    return str(getattr(annotation, "__name__", annotation))
