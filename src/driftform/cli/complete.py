"""What a shell completes: where a function returns nothing for the word so far, the shell completes names of files."""

from collections.abc import Callable, Iterable
from pathlib import Path


def complete_study(incomplete: str) -> list[str]:
    """Complete the name of a built-in scenario or of a study file here."""
    from driftform.study.sources import read_scenarios

    return _begin_with(incomplete, [*read_scenarios(), *map(str, Path().glob("*.toml"))])


def complete_run(incomplete: str) -> list[str]:
    """Complete a directory, with a slash after it if it is not a run."""
    parent = Path(incomplete if incomplete.endswith("/") else Path(incomplete).parent)
    folders = [path for path in (*parent.glob("*"), *Path().glob("runs/*")) if path.is_dir()]
    return _begin_with(incomplete, (f"{p}" if (p / "run.db").is_file() else f"{p}/" for p in folders))


def complete_plugin(seam: str) -> Callable[[str], list[str]]:
    """Return a function that completes the name of a plugin of a seam."""

    def complete(incomplete: str) -> list[str]:
        from driftform.plugins.registry import registry

        return _begin_with(incomplete, (row.name for row in registry().seam(seam)))

    return complete


def complete_setting(incomplete: str) -> list[str]:
    """Complete a key of a study, with the equals sign after it."""
    from pydantic import BaseModel

    from driftform.interfaces import NAMED
    from driftform.plugins.registry import registry
    from driftform.study.study import SELECTED, RunOptions
    from driftform.util.options import describe
    from driftform.water import Scenario
    from driftform.water.flow import FLOWS

    tables: list[tuple[str, type[BaseModel]]] = [
        ("", Scenario),
        ("run.", RunOptions),
        *(("flow.", profile) for profile in FLOWS.values()),
    ]
    for seam in (seam for seam in (*SELECTED, *NAMED) if incomplete[: len(seam)] == seam[: len(incomplete)]):
        above = f"{seam}." if seam in SELECTED else f"{seam}.{{}}."
        tables += [(above.format(p.name), p.cls.Options) for p in registry().seam(seam) if p.cls is not None]
    return _begin_with(incomplete, (f"{above}{row['option']}=" for above, model in tables for row in describe(model)))


def _begin_with(incomplete: str, names: Iterable[str]) -> list[str]:
    return sorted({name for name in names if name.startswith(incomplete)})
