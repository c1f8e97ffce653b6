"""How fast the tracer is, as ratios to others that take turns with it; what was gained once is held."""
