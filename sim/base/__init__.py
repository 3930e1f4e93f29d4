"""General tools that know nothing of granular flow: errors, YAML, files, damage, plug-ins."""
