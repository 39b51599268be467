"""The world: true motion, road, sensors, events, the recorder, and its process."""
