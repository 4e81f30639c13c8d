"""Cells reached: from many stances, by the sector of any arm (5.1.2)."""
