"""Built-in scenarios: TOML files, addressed by their name."""
