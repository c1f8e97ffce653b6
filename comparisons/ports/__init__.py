"""Ground truth for other ports of the document: pictures, a bundle of data, and a checker that speaks a protocol."""
