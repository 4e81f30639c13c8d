"""taskgist: learn what a task means for another person, from one to a few demonstrations."""
