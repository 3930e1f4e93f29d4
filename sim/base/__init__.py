"""What any program needs and what knows nothing of granular flow: errors, YAML, files, damage."""
