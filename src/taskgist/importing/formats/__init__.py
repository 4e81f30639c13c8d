"""Readers of published formats of motion capture, a file each; ``importing.readers`` lists them."""
