"""The facade and the command line of raytruth."""
