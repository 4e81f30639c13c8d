"""From what a task means to what a robot does: goals, places, grasps, stands, motions."""
