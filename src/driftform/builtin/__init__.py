"""Plugins and scenarios of the core; the plugins register through the same hooks as any other."""
