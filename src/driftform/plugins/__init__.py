"""Plugins: their hooks, where they are found, checks of what they return, and templates of new ones."""
