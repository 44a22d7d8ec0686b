"""Laws without a name: screened in closed form, refitted in free run, chosen on rows that were not fitted."""
