"""Agents opened by name: what they are, and how sensitive their flights are."""
