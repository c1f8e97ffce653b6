"""Speed charted against accuracy: every first-hit method and every converter over a sweep of its own parameter.

Accuracy is recomputed here from the pictures, against proven first hits; no method's own claim enters. What is timed is
never what is judged: the accuracy run comes first, the timed runs take turns afterwards.
"""
