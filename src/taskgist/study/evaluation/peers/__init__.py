"""Other learners on the very same facts, each behind a door of its own."""
