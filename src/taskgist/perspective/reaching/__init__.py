"""Reaching: the sectors of arms, what is held, and the ability to reach with effort (5.1.2)."""
