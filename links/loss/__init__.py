"""The loss models, one module each: every module here has a record `LOSS`."""
