"""How results are shown: sections, style of pictures, digits, HTML pages, files."""
