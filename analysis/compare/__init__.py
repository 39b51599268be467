"""Compares runs: their scenarios, figures and pictures side by side."""
