"""Vehicles of many runs side by side: `vehicles` works on floats, this package on arrays.

An array has an entry for each vehicle of each run. Entry s · n + i is vehicle i + 1 of run s, where
a run has n vehicles. The arithmetic is that of `vehicles` and `laws`. This package does the
bookkeeping: which beacons each vehicle has received, and to which vehicles a formula applies.
"""
