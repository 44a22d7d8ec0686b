"""Recordings of joints and of tube shapes: read, traced from photographs, summed up, and asked for their noise."""
