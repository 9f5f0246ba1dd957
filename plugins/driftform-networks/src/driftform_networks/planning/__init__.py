"""Releases of bodies: one of them, the best fleet, and the plan of an inspection."""
