"""The options of a plugin, as the command line and the docs describe them."""

from typing import Annotated, Literal

from pydantic import Field

from driftform.util.options import Table, describe, option


def test_types_are_written_as_people_write_them_and_a_default_that_is_missing_is_told():
    class Needy(Table):
        genome: str = option(..., "the genome to try")
        box: tuple[Annotated[float, Field(gt=0)], float] = option((1.0, 2.0), "width and height", "m")
        names: tuple[str, ...] = option((), "names of all")
        way: Literal["up", "down"] | None = option(None, "where to")

    assert [(row["option"], row["type"], row["default"]) for row in describe(Needy)] == [
        ("genome", "str", "required"),
        ("box", "[float, float]", (1.0, 2.0)),
        ("names", "list of str", ()),
        ("way", "'up' or 'down' or none", None),
    ]


def test_a_table_of_options_within_is_told_with_dotted_names():
    class Inner(Table):
        joint: str = option("auto", "kind of joint")

    class Outer(Table):
        inner: Inner | None = option(None, "how it is cut")

    assert [(row["option"], row["type"]) for row in describe(Outer)] == [
        ("inner", "table or none"),
        ("inner.joint", "str"),
    ]
