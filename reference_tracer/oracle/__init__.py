"""What the fast tracer is held against: the same model, computed another way."""
