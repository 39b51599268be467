"""Laws side by side: one scenario, the same seeds, and a table with intervals."""
