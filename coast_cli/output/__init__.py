"""How answers leave the program: a small module a format, atomic files, provenance, the meaning of columns."""
