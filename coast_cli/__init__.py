"""Design and test of the COAST guidewire robot: two notched nitinol tubes, one inside the other, bent by one tendon."""

__version__ = "0.1.0"
