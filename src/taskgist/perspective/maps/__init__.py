"""Ability maps: where an agent sees and reaches, with which effort, and where an object could stand."""
