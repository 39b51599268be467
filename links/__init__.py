"""What lies between two vehicles: distance, and loss and latency of the frames between them."""
