"""Evaluates the paper's claims from many runs: evidence, claims, tables and pictures."""
