"""What runs renderers against each other and measures how far their pictures agree."""
