"""Computes figures of merit from what a log holds; draws nothing."""
