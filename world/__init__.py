"""The truth: dynamics, road, sensors, events, the recorder, and its process."""
