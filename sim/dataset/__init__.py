"""From run files to one dataset: what replicates say together, measures, regimes, boundaries."""
