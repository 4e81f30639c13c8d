"""Grasps: sampled on shapes, kept by form, judged by collisions."""
