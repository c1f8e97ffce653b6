"""Ports of the document, judged: their pictures, their answers, and the mistakes that these look like."""
