"""Configuration files: pydantic documents, where each key stands in its file, and the way to mechanics."""
