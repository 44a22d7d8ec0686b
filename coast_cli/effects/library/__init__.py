"""One effect a file: what it is, its parameters with ranges and sources, and the stages at which it acts."""
