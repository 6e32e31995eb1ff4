"""Charts on the page: SVG and HTML with links, light or dark, which whoever looks may click."""
