"""Packages that a plugin needs, and imports only when it works."""

from importlib import util


def require_module(module: str) -> None:
    """Check that a module is installed which a plugin imports later, so that the plugin is unavailable without it.

    Raises
    ------
    ModuleNotFoundError
        if the module is not installed.
    """
    if util.find_spec(module) is None:
        raise ModuleNotFoundError(f"No module named '{module}'", name=module)
