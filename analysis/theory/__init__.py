"""The linear theory of the control laws, and its predictions for a run."""
