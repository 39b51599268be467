"""A page in the browser that shows a run from its log, afterwards or while it goes on."""
