"""The chapters of a report, each with tables and pictures of a run."""
