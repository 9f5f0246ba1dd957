"""Options for several exporters at once, as settings of a study: a kit that fits a printer."""

from collections.abc import Iterable, Mapping

from driftform.errors import InputError, did_you_mean
from driftform.interfaces import Printer
from driftform.registry import registry


def list_exporter_settings(formats: Iterable[str], options: Mapping[str, tuple[str, str]]) -> list[str]:
    """Return the settings that give each exporter the same options.

    Parameters
    ----------
    formats
        names of exporters that are installed.
    options
        for each key its value as a setting has it, and how the user asked for it.

    Raises
    ------
    InputError
        if an exporter has no such option; the message names those that have it.
    """
    settings = []
    for name in formats:
        fields = registry().find("exporter", name).Options.model_fields
        for key, (value, asked) in options.items():
            if key not in fields:
                having = [
                    row.name
                    for row in registry().seam("exporter")
                    if row.cls is not None and key in row.cls.Options.model_fields
                ]
                known = did_you_mean(key, fields) or (f"; {', '.join(having)} have it" if having else "")
                raise InputError(f"{asked}: exporter '{name}' has no option '{key}'{known}")
            settings.append(f"exporter.{name}.{key}={value}")
    return settings


def list_kit_settings(formats: Iterable[str], printer: Printer) -> list[str]:
    """Return the settings that make exporters write a kit that fits a printer.

    Raises
    ------
    InputError
        if an exporter writes no kits.
    """
    options = {"kit": "true", "nozzle": repr(printer.nozzle), "bed": repr(list(printer.bed))}
    return list_exporter_settings(formats, {key: (value, "--kit") for key, value in options.items()})
