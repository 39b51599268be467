"""Sweeps: a scenario over a grid or a sample of its settings, each over several seeds."""
