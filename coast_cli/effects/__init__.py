"""Physics that the base model leaves out: one effect a file, their catalogue, and the forward model they act in."""
