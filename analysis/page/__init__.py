"""Presents results: sections, style of pictures, digits, HTML pages, files."""
