"""Vehicles: estimation, prediction, decision, beacons, and their process."""
