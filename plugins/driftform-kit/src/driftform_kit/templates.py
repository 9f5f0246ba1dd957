"""Texts of several lines, from the templates of this package: what ``driftform trim`` prints, and the steps of the assembly sheet."""

from importlib.resources import files
from typing import Any


def fill_template(name: str, **facts: Any) -> list[str]:
    """Return the lines of a template with the facts in it, without empty ones."""
    from jinja2 import Environment, StrictUndefined

    environment = Environment(undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True)
    text = environment.from_string(files(__package__).joinpath(name).read_text("utf-8")).render(facts)
    return [line for line in text.splitlines() if line.strip()]
