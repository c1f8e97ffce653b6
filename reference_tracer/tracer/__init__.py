"""The fast tracer: a camera's rays, waves of them through a scene, what they meet, and the picture they make."""
