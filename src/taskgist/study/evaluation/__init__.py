"""Evaluation: how well tasks are learned, from many demonstrations, under noise, and beside other learners."""
