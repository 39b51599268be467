"""Traffic of human drivers and equipped cars: waves on a ring, and growing shares of such cars."""
