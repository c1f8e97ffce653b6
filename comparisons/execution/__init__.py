"""How cases are made: in processes of their own, several at a time, each kept by all that can change it."""
