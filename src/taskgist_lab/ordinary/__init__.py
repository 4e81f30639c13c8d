"""Ordinary furnished rooms, and what any person would say who in them gets at what: it asks no perspective."""
