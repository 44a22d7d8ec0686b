"""Many designs at once: ranking pairs, stroke tables, and checks against limits."""
