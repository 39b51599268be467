"""The channel between vehicles: range, loss, latency and delivery of frames, and its process."""
