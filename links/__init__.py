"""Links between vehicles: distance, and loss and latency of frames."""
