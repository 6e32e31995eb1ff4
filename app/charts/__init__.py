"""Results as charts: in the page, on paper, and as files."""
