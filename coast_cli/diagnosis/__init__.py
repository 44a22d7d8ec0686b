"""From a recording that disagrees to what was left out: fit, locate, choose, report."""
