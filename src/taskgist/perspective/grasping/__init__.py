"""Grasping: grasps of objects by hands, and the ability to grasp with effort (5.1.3)."""
