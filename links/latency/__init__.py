"""The distributions of latency, one module each: every module here has a record `LATENCY`."""
