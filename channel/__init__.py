"""What is between vehicles: technologies, range, loss, latency, delivery, and its process."""
