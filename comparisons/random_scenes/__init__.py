"""Random scenes of one object, judged pixel by pixel by an oracle that shares nothing with the tracer.

grammar.py      a seed to a scene
arithmetic.py   a formula's text to exact numbers
oracle.py       what a ray meets and the light it brings, with 60 digits
judge.py        a picture held against the oracle
suite.py        many scenes, in child processes (worker.py)
"""
