"""No more than a scene needs: finds by measuring the least that keeps a picture within a tolerance, and checks it.

`search` tries what a scene can do without, `decisions` decides parameter by parameter, `measure` makes a plan of the
decisions, checks it on pixels held back and times what it saves.
"""
