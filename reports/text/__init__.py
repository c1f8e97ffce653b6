"""Words and numbers, as every page writes them."""
