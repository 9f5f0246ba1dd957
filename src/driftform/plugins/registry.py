"""Discovers plugins through the entry-point group ``driftform``, and finds their classes by seam and name.

A broken plugin is listed with the reason; only selecting it is an error.
"""

import reprlib
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cache
from typing import Any

from pydantic import ValidationError

from driftform.errors import InputError, WorkFailedError, describe_error, did_you_mean
from driftform.interfaces import SEAMS, Plugin
from driftform.plugins.discovery import PluginModule, find_modules
from driftform.plugins.faults import report_faults
from driftform.plugins.hookspecs import HOOKS
from driftform.util.options import Table, check_defaults


@dataclass(frozen=True)
class Contribution:
    """One class that a distribution contributes to a seam, or the reason why it is unavailable.

    Attributes:
        seam: seam of the class; empty if the module with the hooks could not be loaded.
        name: name of the class, or of the entry point if the class is unavailable.
        distribution, version: name and version of the distribution.
        state: ``"ok"``, or the reason why the class is unavailable.
        cls: the class, ``None`` if unavailable.
    """

    seam: str
    name: str
    distribution: str
    version: str
    state: str
    cls: type[Plugin[Any]] | None = None

    @property
    def available(self) -> bool:
        """True if the class can be used."""
        return self.cls is not None


class Registry:
    """The installed plugins."""

    def __init__(self) -> None:
        self._modules: list[PluginModule] = []
        self._broken: list[Contribution] = []
        self._seams: dict[str, list[Contribution]] = {}
        for found in find_modules():
            if problem := found.problem or _find_wrong_hooks(found):
                self._broken.append(Contribution("", found.name, found.distribution, found.version, problem))
            else:
                self._modules.append(found)

    def seam(self, seam: str) -> list[Contribution]:
        """Return the contributions to one seam, by name; imports the implementations."""
        if seam not in self._seams:
            rows: list[Contribution] = []
            for origin in self._modules:
                if (hook := origin.find_hook(f"driftform_{seam}")) is None:
                    continue
                where = origin.distribution, origin.version
                try:
                    classes = _check_classes(hook(), SEAMS[seam])
                except (Exception, SystemExit) as error:
                    state = f"unavailable: {describe_error(error)}"
                    rows.append(Contribution(seam, origin.name, *where, state))
                else:
                    rows.extend(Contribution(seam, cls.name, *where, "ok", cls) for cls in classes)
            self._seams[seam] = sorted(rows, key=lambda row: (row.name, row.distribution))
        return self._seams[seam]

    def contributions(self) -> list[Contribution]:
        """Return all contributions, including broken ones, by seam and name."""
        return [row for seam in SEAMS for row in self.seam(seam)] + self._broken

    def find(self, seam: str, name: str) -> type[Plugin[Any]]:
        """Return the class with this name.

        Raises InputError if no plugin has the name, two plugins claim it, or its plugin cannot be imported.
        """
        rows = [row for row in self.seam(seam) if row.name == name]
        usable = [row for row in rows if row.cls is not None]
        if len(usable) > 1:
            claimants = " and ".join(f"{row.distribution} {row.version}" for row in usable)
            raise InputError(f"{seam} '{name}' is claimed by {claimants}; uninstall one of them")
        if usable and usable[0].cls is not None:
            return usable[0].cls
        broken = rows or [row for row in self._broken if row.name == name]
        if broken:
            raise InputError(f"{seam} '{name}' ({broken[0].distribution}) is {broken[0].state}")
        known = [row.name for row in self.seam(seam) if row.available]
        unusable = [row for row in (*self.seam(seam), *self._broken) if not row.available]
        more = "".join(f"; {row.distribution} is {row.state}" for row in unusable)
        raise InputError(f"no {seam} is named '{name}'{did_you_mean(name, known)}{more}")

    def check_seams(self, seams: Iterable[str]) -> None:
        """Check that for each of some seams a distribution is installed, whether it works or not.

        Raises InputError if it is missing, as where driftform was installed without its dependencies.
        """
        missing = [seam for seam in seams if not self.seam(seam)]
        if missing and not self._broken:
            raise InputError(
                f"no plugin for {', '.join(missing)} is installed: in a clone of driftform run 'uv sync', "
                "elsewhere 'pip install driftform'"
            )

    def create(self, seam: str, name: str, options: Mapping[str, Any], **more: Any) -> Any:
        """Create an instance of the class with this name from its table of options.

        Raises:
            InputError: like :meth:`find`.
            WorkFailedError: if the class fails.
            pydantic.ValidationError: if the options do not fit the model of the class.
        """
        cls = self.find(seam, name)
        checked = self.check_options(seam, name, options)
        with report_faults():
            return cls(checked, **more)

    def check_options(self, seam: str, name: str, options: Mapping[str, Any]) -> Table:
        """Return the options of the class with this name, from its table of options.

        Raises:
            InputError: like :meth:`find`.
            WorkFailedError: if the model of the class fails, other than by a ValueError.
            pydantic.ValidationError: if the options do not fit the model.
        """
        model = self.find(seam, name).Options
        try:
            return model.model_validate(dict(options))
        except ValidationError:
            raise
        except (Exception, SystemExit) as error:
            what = describe_error(error, with_place=True)
            raise WorkFailedError(f"{seam} '{name}' failed to check its options: {what}") from None


@cache
def registry() -> Registry:
    """Return the registry of this process, which is created once."""
    return Registry()


def _find_wrong_hooks(plugin: PluginModule) -> str:
    """Return why the module of a plugin is unavailable: by a hook that does not exist, or without any; ``""`` if it is not."""
    found = [name for name in dir(plugin.module) if plugin.find_hook(name) is not None]
    if unknown := [name for name in found if name not in HOOKS]:
        return f"unavailable: AttributeError: unknown hook {unknown[0]}{did_you_mean(unknown[0], HOOKS)}"
    if found:
        return ""
    unmarked = [name for name in dir(plugin.module) if name in HOOKS]
    remedy = "it needs a function such as driftform_fitness() with @hookimpl above it"
    if unmarked:
        remedy = f"write @hookimpl above {unmarked[0]}()"
    return f"unavailable: registers nothing: {plugin.place} has no hook; {remedy}"


def _check_classes(returned: Any, interface: type[Plugin[Any]]) -> list[type[Plugin[Any]]]:
    if not isinstance(returned, type | list | tuple):
        raise TypeError(f"the hook returned a {type(returned).__name__}, expected a class or a list of classes")
    classes = [returned] if isinstance(returned, type) else list(returned)
    if not classes:
        raise TypeError("the hook returned no class")
    for cls in classes:
        if not (isinstance(cls, type) and issubclass(cls, interface)):
            raise TypeError(f"{cls!r} is not a {interface.__name__}")
        if not isinstance(vars(cls).get("name"), str):
            # The name of another class would make both unusable.
            raise TypeError(f"{cls.__name__} has no name of its own")
        if missing := sorted(getattr(cls, "__abstractmethods__", ())):
            raise TypeError(f"{cls.__name__} does not implement {', '.join(missing)}")
        if not (isinstance(cls.Options, type) and issubclass(cls.Options, interface.Options)):
            raise TypeError(
                f"Options of {cls.__name__} is {reprlib.repr(cls.Options)}, expected a class that derives from "
                f"{interface.Options.__name__} of driftform.interfaces"
            )
        try:
            check_defaults(cls.Options)
        except ValueError as error:
            raise ValueError(f"Options of {cls.__name__}: {error}") from None
    return classes
