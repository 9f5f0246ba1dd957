"""Trajectories after the simulation: interpolation, closest approach, forces, compression and coverage."""
