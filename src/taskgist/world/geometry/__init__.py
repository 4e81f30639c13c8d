"""Geometry: transforms, rays, shapes, distances, convex parts."""
