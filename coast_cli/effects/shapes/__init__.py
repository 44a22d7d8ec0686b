"""What a shape model can leave out: one effect a file, and their catalogue."""
