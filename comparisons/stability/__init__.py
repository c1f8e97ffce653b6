"""Where first-hit methods fail: families of cases, each with one difficulty, an exact answer and, if known, a law."""
