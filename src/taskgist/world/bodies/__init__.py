"""Bodies: agent profiles, and people and robots made of them."""
