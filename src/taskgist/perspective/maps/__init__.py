"""Ability maps: where an agent sees (``seen``) and reaches (``reached``), how easily; where an object could stand."""
