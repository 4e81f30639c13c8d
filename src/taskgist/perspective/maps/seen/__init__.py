"""Cells seen: from many stances, the head aimed at each of them, past whatever may hide it (5.1.1)."""
