"""How well tasks are performed: rooms, what can be solved there, a second auditor, and trials."""
