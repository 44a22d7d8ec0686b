"""How answers leave the program: one small module a format, atomic files, provenance, and the meaning of each column."""
