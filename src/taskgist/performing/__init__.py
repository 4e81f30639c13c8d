"""Performing: plans carried out, audited frame by frame, and judged by the facts that explain demonstrations."""
