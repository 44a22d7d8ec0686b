"""The mechanics of notched tubes, tube pairs and their tendon joint: numpy only, SI only, no files."""
