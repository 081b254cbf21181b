"""Reports people look at: one offline HTML file, and figures as PNG and SVG."""
