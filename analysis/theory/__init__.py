"""Linear theory of the control laws, and what it predicts for a run."""
