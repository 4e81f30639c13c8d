"""Speed, as ratios against a peer or the slow twin in the same run: ``make bench``."""
