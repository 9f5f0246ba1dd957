"""Plugins: the hooks that they implement, where they are found, and what is checked of what they return."""
