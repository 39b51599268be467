"""The chapters of a report: what each shows of a run, as tables and pictures."""
