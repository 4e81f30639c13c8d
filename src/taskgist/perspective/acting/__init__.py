"""Virtual actions: what an agent may do, under which constraints, and where that leads (Eq. 1-6, 5.1.4)."""
