"""From a results document and its image planes to a report: a folder of pages that opens from disk."""

from .build import OUTPUT, build

__all__ = ["OUTPUT", "build"]
