"""What `certify` finds out about a scene and a method."""

from __future__ import annotations

from dataclasses import asdict, dataclass, field, fields


@dataclass
class KindCount:
    """Rays of one kind: how the proofs decide them and how the audited method compares.

    For shadow rays a hit is a light that loses something on the way, a miss one that arrives whole.
    """

    rays: int = 0
    hits: int = 0  # proven
    misses: int = 0  # proven
    settled: int = 0  # undecided by interval arithmetic; exact arithmetic confirms the audited method
    undecided: int = 0  # by both
    wrong: int = 0  # the audited method contradicts a proof
    refused: int = 0  # the audited method calls itself undecided where the proofs are not


@dataclass
class Finding:
    """A way in which rays are wrong, and one of them."""

    fault: str
    rays: str  # their kind
    object: str
    count: int
    example: str


@dataclass
class Audit:
    """python-flint's exact decisions of sampled rays, held against both methods."""

    rays: int = 0
    by_kind: dict[str, int] = field(default_factory=dict)
    at_edges: int = 0
    contradictions: int = 0  # of what the proofs claim
    wrong: int = 0  # of what the audited method claims
    undecided: dict[str, int] = field(default_factory=dict)  # reason -> rays python-flint could not decide either
    touching: int = 0  # rays that touch an object without crossing it (decision M1)
    largest_error: float = 0.0  # of the audited method's t
    largest_share: float = 0.0  # of its enclosure that the error of a proven t uses up


@dataclass
class PathErrors:
    """Whole pixel paths against the 77-digit tracer."""

    paths: int = 0
    rays: int = 0
    deepest: int = 0  # generation
    largest_error: float = 0.0  # of a colour channel, where all decisions are the same
    above_bar: int = 0  # paths with a larger error than `bar` although all decisions are the same
    bar: float = 1e-10
    near_critical: list[str] = field(default_factory=list)  # a ray is decided otherwise, as after a nudge of rounding
    wrong: list[str] = field(default_factory=list)  # a ray is decided otherwise, whatever the rounding
    not_tried: str = ""


@dataclass
class Certificate:
    """Whether a method's picture of a scene holds against proofs, exact decisions and 77-digit paths."""

    scene: str
    scene_hash: str
    method: str
    width: int
    height: int
    samples: int
    kinds: dict[str, KindCount] = field(default_factory=dict)
    findings: list[Finding] = field(default_factory=list)
    undecided: list[Finding] = field(default_factory=list)  # `fault` is the reason
    unproven_bounds: list[str] = field(default_factory=list)  # objects; no method relies on their bounds
    largest_gap: float = 0.0  # between the audited method's t and the proven one
    largest_radius: float = 0.0  # of an enclosure
    audit: Audit = field(default_factory=Audit)
    paths: PathErrors = field(default_factory=PathErrors)
    seconds: float = 0.0
    versions: dict[str, str] = field(default_factory=dict)

    @property
    def rays(self) -> int:
        return sum(k.rays for k in self.kinds.values())

    @property
    def undecided_rays(self) -> int:
        return sum(k.undecided for k in self.kinds.values())

    @property
    def passed(self) -> bool:
        """No wrong ray, no contradiction, no path off its high-precision recomputation."""
        faulty_paths = self.paths.above_bar or self.paths.wrong
        return not (self.findings or self.audit.contradictions or self.audit.wrong or faulty_paths)

    def document(self) -> dict:
        """Everything, as JSON would hold it."""
        return asdict(self) | {"rays": self.rays, "undecided_rays": self.undecided_rays, "passed": self.passed}

    @classmethod
    def of(cls, document: dict) -> Certificate:
        """The certificate that `document` tells of."""
        own = {name: document[name] for name in (f.name for f in fields(cls))}
        listed = {name: [Finding(**found) for found in own[name]] for name in ("findings", "undecided")}
        kinds = {name: KindCount(**count) for name, count in own["kinds"].items()}
        return cls(**{**own, **listed, "kinds": kinds, "audit": Audit(**own["audit"]), "paths": PathErrors(**own["paths"])})
