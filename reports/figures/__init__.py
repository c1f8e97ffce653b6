"""Pictures, error maps and charts."""
