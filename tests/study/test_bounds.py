"""Every number that a study can set has a lower and an upper bound, or a stated reason."""

from types import UnionType
from typing import Annotated, Union, get_args, get_origin

import pytest
from pydantic import BaseModel
from pydantic.fields import FieldInfo

from driftform.plugins.registry import registry
from driftform.study import RunOptions
from driftform.water import Scenario

LOWER, UPPER = ("ge", "gt"), ("le", "lt")


def read_bounds(metadata):
    """Return the constraints that the metadata of a type sets."""
    inner = [m for info in metadata for m in (info.metadata if isinstance(info, FieldInfo) else [info])]
    return {name for m in inner for name in (*LOWER, *UPPER) if getattr(m, name, None) is not None}


def find_unbounded(annotation, bounds, path, above=()):
    """Yield the path of each number in a type whose bounds, with those around it, are not two."""
    origin, arguments = get_origin(annotation), get_args(annotation)
    if origin is Annotated:
        yield from find_unbounded(arguments[0], bounds | read_bounds(arguments[1:]), path, above)
    elif origin in (Union, UnionType, tuple, dict, list):
        inner = bounds if origin in (Union, UnionType) else set()
        for part in arguments:
            yield from find_unbounded(part, inner, path, above)
    elif isinstance(annotation, type) and issubclass(annotation, BaseModel):
        # A branch of a pipe has parts, which may have branches.
        if annotation not in above:
            yield from walk(annotation, path, above)
    elif annotation in (int, float) and not (bounds & set(LOWER) and bounds & set(UPPER)):
        yield path


def walk(model, path, above=()):
    for name, field in model.model_fields.items():
        extra = field.json_schema_extra if isinstance(field.json_schema_extra, dict) else {}
        if not extra.get("unbounded"):
            yield from find_unbounded(field.annotation, read_bounds(field.metadata), f"{path}.{name}", (*above, model))


def list_plugins():
    return [row.cls for row in registry().contributions() if row.cls is not None]


@pytest.mark.parametrize("model", [Scenario, RunOptions])
def test_every_number_of_a_study_has_two_bounds(model):
    assert list(walk(model, model.__name__)) == []


@pytest.mark.parametrize("plugin", list_plugins(), ids=lambda cls: f"{cls.__module__}:{cls.name}")
def test_every_number_of_a_plugin_has_two_bounds(plugin):
    assert list(walk(plugin.Options, plugin.name)) == []


def test_the_walk_finds_a_number_without_a_bound():
    class Inner(BaseModel):
        point: tuple[float, float] = (0.0, 0.0)

    class Outer(BaseModel):
        inner: Inner = Inner()
        count: int | None = None
        name: str = ""

    assert sorted(walk(Outer, "o")) == ["o.count", "o.inner.point", "o.inner.point"]
