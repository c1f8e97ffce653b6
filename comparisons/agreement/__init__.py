"""Who agrees with whom: every pair of renderers on every scene, the odd one out by majority, and how tight limits are."""
