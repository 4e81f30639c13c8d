"""Seeing: images, visibility, and the ability to see with effort (5.1.1)."""
