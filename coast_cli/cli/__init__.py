"""The commands, one short file each: parse, call, write. Heavy modules are imported inside the functions."""
