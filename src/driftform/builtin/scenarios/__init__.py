"""Built-in scenarios: TOML files, selected by name."""
