"""The lab: simulated demonstrations, the paper reproduced, and how well tasks are learned."""
