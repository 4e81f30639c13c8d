"""Other renderers of the same scene, seen through the same eye: each gives the shape in every pixel of an image."""
