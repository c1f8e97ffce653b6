"""From scenes of implicit surfaces to what other renderers take: meshes, and scenes of those renderers."""
