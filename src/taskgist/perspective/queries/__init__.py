"""Queries: who could what by which actions, what that takes, and why not with less (Eq. 7 and 8)."""
