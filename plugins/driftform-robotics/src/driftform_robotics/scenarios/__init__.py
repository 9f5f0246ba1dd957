"""Scenarios that need this plugin: TOML files, addressed by name."""
