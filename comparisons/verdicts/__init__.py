"""From two pictures to a verdict: what is measured, what it is held to, what rounding excuses, who is the odd one out."""
