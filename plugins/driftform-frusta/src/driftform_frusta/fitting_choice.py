"""A fitting as a study names it: by its plugin, with the options of that beside it."""

from collections.abc import Mapping
from typing import Any

from pydantic import ConfigDict, ValidationError, model_validator

from driftform.errors import did_you_mean
from driftform.interfaces import Fitting, Table, option


class FittingChoice(Table):
    """A fitting by its name, with its own options beside it."""

    model_config = ConfigDict(extra="allow")
    use: str = option(..., "name of the fitting")

    @model_validator(mode="before")
    @classmethod
    def _fill_in(cls, values: Any) -> Any:
        if not (isinstance(values, Mapping) and isinstance(values.get("use"), str)):
            return values
        try:
            return {"use": values["use"], **_make(**values).options.model_dump(mode="json")}
        except ValidationError as error:
            first = error.errors(include_url=False)[0]
            where = ".".join(map(str, first["loc"]))
            raise ValueError(f"the fitting '{values['use']}' refuses '{where}': {first['msg']}") from None

    def make(self) -> Fitting[Any]:
        """Return the fitting."""
        return _make(self.use, **(self.model_extra or {}))


def _make(use: str, **options: Any) -> Fitting[Any]:
    from driftform import Study

    known: dict[str, Any] = {row.name: row.cls for row in Study.list_plugins("fitting")}
    if (cls := known.get(use)) is None:
        raise ValueError(f"no fitting is named '{use}'{did_you_mean(use, known)}")
    made: Fitting[Any] = cls(cls.Options.model_validate(options))
    return made
