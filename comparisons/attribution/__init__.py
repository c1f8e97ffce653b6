"""Why two pictures differ: the first stage of section 4 at which two renderers part.

A renderer can only be asked for pictures. So every stage is put to the question by a scene derived from the given one
in which all later stages have nothing to do: `derived` has the scenes, `bounds` says how far two faultless renderers
may be apart on each, `stages` compares, `measure` names the first stage that fails and follows the worst pixels through
both renderers (`rays`). `cases` holds faults made on purpose, and finds out who notices them.
"""
