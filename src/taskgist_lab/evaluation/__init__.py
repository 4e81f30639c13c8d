"""Evaluation: how well tasks are learned from generated demonstrations."""
