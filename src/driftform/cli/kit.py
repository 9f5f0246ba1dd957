"""What commands that make files of kits share: the bed as slicers have it, and options for several exporters at once."""

from collections.abc import Iterable, Mapping

from driftform.scenario import Vector

MM_PER_M = 1000.0


def parse_bed(text: str) -> Vector:
    """Read ``X,Y,Z`` in mm as width, depth and height in m.

    Raises
    ------
    InputError
        where it is something else.
    """
    from driftform.errors import InputError

    try:
        x, y, z = (float(side) for side in text.split(","))
    except ValueError:
        raise InputError(f"--bed {text}: should be three lengths in mm, such as 250,210,210") from None
    if not all(0 < side < 1e5 for side in (x, y, z)):
        raise InputError(f"--bed {text}: should be three lengths in mm above 0, such as 250,210,210")
    return x / MM_PER_M, y / MM_PER_M, z / MM_PER_M


def exporter_settings(formats: Iterable[str], options: Mapping[str, tuple[str, str]]) -> list[str]:
    """Return the settings that give each exporter the same options.

    Parameters
    ----------
    formats
        names of exporters that are installed.
    options
        for each key its value as a setting has it, and how the command line says it.

    Raises
    ------
    InputError
        where an exporter has no such option; the message names those that have it.
    """
    from driftform.errors import InputError, did_you_mean
    from driftform.registry import registry

    settings = []
    for name in formats:
        fields = registry().find("exporter", name).Options.model_fields
        for key, (value, told) in options.items():
            if key not in fields:
                having = [
                    row.name
                    for row in registry().seam("exporter")
                    if row.cls is not None and key in row.cls.Options.model_fields
                ]
                known = did_you_mean(key, fields) or (f"; {', '.join(having)} have it" if having else "")
                raise InputError(f"{told}: exporter '{name}' has no option '{key}'{known}")
            settings.append(f"exporter.{name}.{key}={value}")
    return settings
