"""The paper's evaluation from many runs: evidence, claims, tables and pictures."""
