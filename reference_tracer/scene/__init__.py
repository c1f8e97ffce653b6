"""What is to be rendered: the scene format, reading it from untrusted files, and the scenes of the document."""
