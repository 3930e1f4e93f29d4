"""General tools that know nothing of granular flow: errors, YAML, files, seals, plug-ins."""
