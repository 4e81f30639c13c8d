"""Geometry: rays, gaps, kinematics, and shapes as they are seen and as they collide."""
