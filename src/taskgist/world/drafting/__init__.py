"""Drafting profiles: a robot's model is looked into, and a profile is written that says why it says what it says."""
