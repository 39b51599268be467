"""Vehicles of many runs side by side: what `vehicles` does with floats, on arrays.

An array has an entry for each vehicle of each run, run by run: entry s · n + i is vehicle i + 1 of
run s, of n vehicles. The arithmetic is that of `vehicles` and `laws`. What stands here is the
book-keeping: who has heard what, and which vehicles a formula is applied to.
"""
